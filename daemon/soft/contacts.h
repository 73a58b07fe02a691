/* contacts: arrays of contacts, and their canonical order: by pair, kind, a, b. */
#ifndef COLLIDED_SOFT_CONTACTS_H
#define COLLIDED_SOFT_CONTACTS_H

#include "soft.h"

typedef struct soft_contacts {
    soft_contact *at;
    size_t count, capacity;
} soft_contacts;

/* No contact stands there twice, so any two differ. */
void soft_contacts_sort(soft_contacts *c, soft_contacts *scratch);
/* Sorts, and keeps the first ones. */
void soft_contacts_keep(soft_contacts *c, soft_contacts *scratch, size_t most);

#endif
