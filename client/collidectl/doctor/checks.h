/* checks: one file a check, or a few that look at the same thing. Each looks and words a finding; it changes nothing.
 * Those that need a daemon are run only when one was heard. */
#ifndef COLLIDED_DOCTOR_CHECKS_H
#define COLLIDED_DOCTOR_CHECKS_H

#include "run.h"

doctor_finding check_interface(doctor *d);    /* the network interface is there and up */
doctor_finding check_multicast(doctor *d);    /* LCM: the interface does multicast */
doctor_finding check_route(doctor *d);        /* LCM: multicast leads to that interface */
doctor_finding check_buffers(doctor *d);      /* the kernel grants the receive buffers that are asked for */
doctor_finding check_participants(doctor *d); /* DDS: room for more participants on this host */
doctor_finding check_wire(doctor *d);         /* all daemons speak our wire */
doctor_finding check_daemon(doctor *d);       /* there is one */
doctor_finding check_interfaces(doctor *d);   /* none on other interfaces, if there is none on ours */
doctor_finding check_domain(doctor *d);       /* none in other domains, if there is none in ours */
doctor_finding check_peer(doctor *d);         /* the host that was named is up and can be heard */
doctor_finding check_silence(doctor *d);      /* DDS: those that announce themselves also tell their endpoints */
doctor_finding check_single(doctor *d);       /* only one daemon */
doctor_finding check_release(doctor *d);      /* it is of our release */
doctor_finding check_health(doctor *d);       /* it is ready, and no limit is reached */
doctor_finding check_gateway(doctor *d);      /* its LCM gateway runs, and stays running */
doctor_finding check_clock(doctor *d);        /* its clock and ours agree */
doctor_finding check_lost(doctor *d);         /* no bodies of lost clients */
doctor_finding check_stale(doctor *d);        /* no bodies past their deadline */
doctor_finding check_losses(doctor *d);       /* nothing is being dropped or refused */

#endif
