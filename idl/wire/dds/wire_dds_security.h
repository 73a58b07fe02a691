/* wire_dds_security: DDS Security for a participant, from a folder as script/make_site makes it: who it is (cert.pem,
 * key.pem, identity_ca.cert.pem), who is not any more (crl.pem, if it is there), and what may be done (governance.p7s,
 * permissions.p7s, permissions_ca.cert.pem). The plug-ins are Cyclone's own, where Debian puts them beside the library.
 * Any thread. */
#ifndef COLLIDED_WIRE_DDS_SECURITY_H
#define COLLIDED_WIRE_DDS_SECURITY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct dds_qos;

/* Is all that the folder needs there and readable, and do certificate, key and authority belong together, today? False
 * with a line in `why`: which file is at fault and what to do. The signed documents are checked by the plug-ins, when
 * the participant is made. */
bool wire_dds_security_check(const char *folder, char *why, size_t why_size);

/* May nobody but its owner, or root, read the key? False with a line in `why` that says what to do. */
bool wire_dds_security_key_is_private(const char *folder, char *why, size_t why_size);

/* When the first of its certificates expires, seconds since the Unix epoch; INT64_MAX: none can be read. */
int64_t wire_dds_security_ends_s(const char *folder);

/* For dds_create_participant: the folder's files and the plug-ins as properties; to be freed by dds_delete_qos. "" or
 * NULL = no security: then NULL. */
struct dds_qos *wire_dds_security_qos(const char *folder);

/* What Cyclone said when a participant could not be made, with the file that is at fault and the remedy; NULL:
 * nothing, it was made, but not its readers and writers. False: it is not about security. */
bool wire_dds_security_explain(const char *folder, const char *said, char *why, size_t why_size);

/* The same without Cyclone's words, for a program whose log is not ours: by reading the signed documents. */
void wire_dds_security_documents(const char *folder, char *why, size_t why_size);

#endif
