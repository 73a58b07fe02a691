/* The properties of DDS Security 1.1, and what is wrong with a folder. Nothing is kept between calls. */
#include "wire_dds_security.h"

#include "wire/wire_file.h"

#include <dds/dds.h>
#include <dlfcn.h>
#include <errno.h>
#include <limits.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/x509.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

static const struct {
    const char *property, *file;
} files[] = {
    {"dds.sec.auth.identity_ca", "identity_ca.cert.pem"},
    {"dds.sec.auth.identity_certificate", "cert.pem"},
    {"dds.sec.auth.private_key", "key.pem"},
    {"dds.sec.access.permissions_ca", "permissions_ca.cert.pem"},
    {"dds.sec.access.governance", "governance.p7s"},
    {"dds.sec.access.permissions", "permissions.p7s"},
};
/* Of the certificates that are refused; a site of an earlier release has none. */
static const char CRL_PROPERTY[] = "org.eclipse.cyclonedds.sec.auth.crl", CRL_FILE[] = "crl.pem";

enum { FILE_COUNT = sizeof files / sizeof files[0], FILE_BYTES_MAX = 1 << 20 };

static const struct {
    const char *property, *library, *name;
} plugins[] = {
    {"dds.sec.auth", "auth", "authentication"},
    {"dds.sec.access", "ac", "access_control"},
    {"dds.sec.crypto", "crypto", "crypto"},
};
enum { PLUGIN_COUNT = sizeof plugins / sizeof plugins[0] };

/* Debian: in a folder named like the library's soname, beside it. Elsewhere: where the loader looks. */
static void plugin_path(const char *name, char path[PATH_MAX])
{
    Dl_info library;
    void *function = NULL;
    dds_entity_t (*create)(dds_domainid_t, const dds_qos_t *, const dds_listener_t *) = dds_create_participant;
    memcpy(&function, &create, sizeof function);
    const char *slash = dladdr(function, &library) && library.dli_fname ? strrchr(library.dli_fname, '/') : NULL;
    int length = slash ? (int)(slash - library.dli_fname) : 0;
    snprintf(path, PATH_MAX, "%.*s/libddsc0debian/libdds_security_%s.so", length, slash ? library.dli_fname : "", name);
    if (!slash || access(path, R_OK) != 0) snprintf(path, PATH_MAX, "dds_security_%s", name);
}

static bool check_file(const char *folder, const char *file, char *why, size_t why_size)
{
    char path[PATH_MAX];
    struct stat is;
    snprintf(path, sizeof path, "%s/%s", folder, file);
    bool there = access(path, R_OK) == 0 && stat(path, &is) == 0;
    if (there && S_ISREG(is.st_mode) && is.st_size > 0) return true;
    snprintf(why, why_size, "security = \"%.200s\": %s: %s: make it by make_site, and let this user read it", folder,
        file, !there ? strerror(errno) : "empty, or not a file");
    return false;
}

/* ---- certificate and key: what the plug-ins would tell later, or never (a wrong key only shows in handshakes) ---- */

static FILE *open_file(const char *folder, const char *file)
{
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s/%s", folder, file);
    char fault[256];
    return wire_file_open(path, FILE_BYTES_MAX, NULL, fault, sizeof fault);
}

static X509 *read_certificate(const char *folder, const char *file)
{
    FILE *f = open_file(folder, file);
    X509 *certificate = f ? PEM_read_X509(f, NULL, NULL, NULL) : NULL;
    if (f) fclose(f);
    return certificate;
}

/* A key with a password would ask for it on the terminal: the empty one is tried. */
static EVP_PKEY *read_key(const char *folder)
{
    FILE *f = open_file(folder, "key.pem");
    char none[] = "";
    EVP_PKEY *key = f ? PEM_read_PrivateKey(f, NULL, NULL, none) : NULL;
    if (f) fclose(f);
    return key;
}

static const char *fault_of(X509 *authority, X509 *own, EVP_PKEY *key)
{
    if (!authority) return "identity_ca.cert.pem is no certificate";
    if (!own) return "cert.pem is no certificate";
    if (!key) return "key.pem is no key, or has a password";
    if (X509_cmp_current_time(X509_get0_notAfter(own)) <= 0) return "cert.pem has expired: renew it: make_site --renew";
    if (X509_cmp_current_time(X509_get0_notAfter(authority)) <= 0)
        return "identity_ca.cert.pem has expired: make a new site by make_site";
    if (X509_cmp_current_time(X509_get0_notBefore(own)) > 0) return "cert.pem is not valid yet: is the clock right?";
    if (X509_verify(own, X509_get0_pubkey(authority)) != 1)
        return "cert.pem is not of the authority of identity_ca.cert.pem: of which site is it?";
    return X509_check_private_key(own, key) == 1 ? NULL : "key.pem is not the key of cert.pem";
}

static bool check_identity(const char *folder, char *why, size_t why_size)
{
    X509 *authority = read_certificate(folder, "identity_ca.cert.pem"), *own = read_certificate(folder, "cert.pem");
    EVP_PKEY *key = read_key(folder);
    const char *fault = fault_of(authority, own, key);
    if (fault) snprintf(why, why_size, "security = \"%.200s\": %s", folder, fault);
    X509_free(authority);
    X509_free(own);
    EVP_PKEY_free(key);
    ERR_clear_error();
    return !fault;
}

static bool has_crl(const char *folder)
{
    char path[PATH_MAX];
    snprintf(path, sizeof path, "%s/%s", folder, CRL_FILE);
    return access(path, F_OK) == 0;
}

/* One that cannot be read, or is of another authority, or over, would refuse everybody, or nobody. */
static bool check_crl(const char *folder, char *why, size_t why_size)
{
    if (!has_crl(folder)) return true;
    FILE *f = open_file(folder, CRL_FILE);
    X509_CRL *crl = f ? PEM_read_X509_CRL(f, NULL, NULL, NULL) : NULL;
    X509 *authority = read_certificate(folder, "identity_ca.cert.pem"), *own = read_certificate(folder, "cert.pem");
    X509_REVOKED *entry = NULL;
    if (f) fclose(f);
    const char *fault = NULL;
    if (!crl || !authority || !own)
        fault = "crl.pem is no list of certificates";
    else if (X509_CRL_verify(crl, X509_get0_pubkey(authority)) != 1)
        fault = "crl.pem is not of the authority of identity_ca.cert.pem: of which site is it?";
    else if (X509_CRL_get0_nextUpdate(crl) && X509_cmp_current_time(X509_CRL_get0_nextUpdate(crl)) <= 0)
        fault = "crl.pem is out of date: renew it: make_site --renew";
    else if (X509_CRL_get0_by_cert(crl, &entry, own) == 1)
        fault = "cert.pem was revoked (crl.pem): make_site makes another one";
    if (fault) snprintf(why, why_size, "security = \"%.200s\": %s", folder, fault);
    X509_CRL_free(crl);
    X509_free(authority);
    X509_free(own);
    ERR_clear_error();
    return !fault;
}

/* Others, and groups but root's and our own, may not read it. systemd hands credentials over with its own marks on
 * root's group. */
bool wire_dds_security_key_is_private(const char *folder, char *why, size_t why_size)
{
    char path[PATH_MAX];
    struct stat is;
    snprintf(path, sizeof path, "%s/key.pem", folder);
    if (stat(path, &is) != 0) return true; /* wire_dds_security_check says so */
    bool group_may = !(is.st_mode & 070) || (!(is.st_mode & 020) && (is.st_gid == 0 || is.st_gid == getegid()));
    if (is.st_uid != geteuid() && is.st_uid != 0)
        snprintf(why, why_size, "security = \"%.200s\": key.pem belongs to another user (%u): do: chown %u '%.200s'",
            folder, (unsigned)is.st_uid, (unsigned)geteuid(), path);
    else if ((is.st_mode & 07) || !group_may)
        snprintf(why, why_size,
            "security = \"%.200s\": key.pem can be read or written by others (mode %03o): do: chmod 600 '%.200s'; and "
            "make "
            "another one, for they may have read it",
            folder, (unsigned)is.st_mode & 0777, path);
    else
        return true;
    return false;
}

/* The end of a certificate, seconds since the Unix epoch; INT64_MAX: there is none. */
static int64_t end_of(const X509 *certificate)
{
    struct tm t;
    return certificate && ASN1_TIME_to_tm(X509_get0_notAfter(certificate), &t) == 1 ? (int64_t)timegm(&t) : INT64_MAX;
}

int64_t wire_dds_security_ends_s(const char *folder)
{
    X509 *all[] = {read_certificate(folder, "cert.pem"), read_certificate(folder, "identity_ca.cert.pem"),
        read_certificate(folder, "permissions_ca.cert.pem")};
    int64_t first = INT64_MAX;
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        if (end_of(all[i]) < first) first = end_of(all[i]);
        X509_free(all[i]);
    }
    ERR_clear_error();
    return first;
}

bool wire_dds_security_check(const char *folder, char *why, size_t why_size)
{
    if (strlen(folder) > PATH_MAX - 64) {
        snprintf(why, why_size, "security: the path is too long");
        return false;
    }
    for (size_t i = 0; i < FILE_COUNT; i++)
        if (!check_file(folder, files[i].file, why, why_size)) return false;
    return check_identity(folder, why, why_size) && check_crl(folder, why, why_size);
}

dds_qos_t *wire_dds_security_qos(const char *folder)
{
    char name[64], value[PATH_MAX + 8], path[PATH_MAX];
    if (!folder || !*folder) return NULL;
    dds_qos_t *q = dds_create_qos();
    for (size_t i = 0; i < FILE_COUNT; i++) {
        snprintf(value, sizeof value, "file:%s/%s", folder, files[i].file);
        dds_qset_prop(q, files[i].property, value);
    }
    if (has_crl(folder)) {
        snprintf(value, sizeof value, "file:%s/%s", folder, CRL_FILE);
        dds_qset_prop(q, CRL_PROPERTY, value);
    }
    for (size_t i = 0; i < PLUGIN_COUNT; i++) {
        plugin_path(plugins[i].library, path);
        snprintf(name, sizeof name, "%s.library.path", plugins[i].property);
        dds_qset_prop(q, name, path);
        snprintf(name, sizeof name, "%s.library.init", plugins[i].property);
        snprintf(value, sizeof value, "init_%s", plugins[i].name);
        dds_qset_prop(q, name, value);
        snprintf(name, sizeof name, "%s.library.finalize", plugins[i].property);
        snprintf(value, sizeof value, "finalize_%s", plugins[i].name);
        dds_qset_prop(q, name, value);
    }
    return q;
}

/* Of the documents; certificate and key have been checked. Cyclone's own words, and what they mean; the first that is
 * met counts. */
static const struct {
    const char *said, *means;
} complaints[] = {
    {"could not be found, opened", "a file is not there, or this user may not read it"},
    {"certificate has expired", "cert.pem has expired: renew it: make_site --renew"},
    {"certificate is not yet valid", "cert.pem is not valid yet: is the clock right?"},
    {"expired", "permissions.p7s have expired: renew them: make_site --renew"},
    {"Validity period not started", "permissions.p7s are not valid yet: is the clock right?"},
    {"Certificate not valid", "cert.pem is not of the authority of identity_ca.cert.pem: of which site is it?"},
    {"Subject name", "permissions.p7s are not those of cert.pem"},
    {"PKCS7", "governance.p7s or permissions.p7s were changed, or are of another site"},
    {"Failed to parse certificate", "cert.pem, identity_ca.cert.pem or permissions_ca.cert.pem is no certificate"},
    {"private key", "key.pem is no key, or has a password"},
    {"load library", "the plug-ins of libddsc0debian are missing"},
    {"security", "make the folder by make_site"},
    {"ermission", "make the folder by make_site"},
};

bool wire_dds_security_explain(const char *folder, const char *said, char *why, size_t why_size)
{
    if (!said) {
        snprintf(why, why_size, "security = \"%.200s\": permissions.p7s do not permit what this program does", folder);
        return true;
    }
    for (size_t i = 0; i < sizeof complaints / sizeof complaints[0]; i++) {
        if (!strcasestr(said, complaints[i].said)) continue;
        snprintf(why, why_size, "security = \"%.200s\": %s (%.200s)", folder, complaints[i].means, said);
        return true;
    }
    return false;
}

/* ---- the signed documents ---- */

/* What the authority signed, as text; false: not this, or not by it. */
static bool read_signed(const char *folder, const char *file, X509 *authority, char *text, size_t text_size)
{
    FILE *f = open_file(folder, file);
    BIO *in = f ? BIO_new_fp(f, BIO_CLOSE) : NULL, *content = NULL, *out = BIO_new(BIO_s_mem());
    PKCS7 *document = in ? SMIME_read_PKCS7(in, &content) : NULL;
    X509_STORE *store = X509_STORE_new();
    bool good = document && store && out && X509_STORE_add_cert(store, authority) == 1 &&
                PKCS7_verify(document, NULL, store, content, out, PKCS7_TEXT) == 1;
    int length = good ? BIO_read(out, text, (int)text_size - 1) : 0;
    text[length > 0 ? length : 0] = '\0';
    X509_STORE_free(store);
    PKCS7_free(document);
    BIO_free(content);
    BIO_free(out);
    BIO_free(in);
    ERR_clear_error();
    return good;
}

/* The times are UTC, as make_site writes them: "2030-01-31T12:00:00". */
static bool is_over(const char *permissions)
{
    char now[32];
    time_t seconds = time(NULL);
    struct tm t;
    const char *tag = "<not_after>", *end = strstr(permissions, tag);
    if (!end || !gmtime_r(&seconds, &t)) return false;
    size_t length = strftime(now, sizeof now, "%Y-%m-%dT%H:%M:%S", &t);
    return strncmp(end + strlen(tag), now, length) <= 0;
}

void wire_dds_security_documents(const char *folder, char *why, size_t why_size)
{
    char text[1 << 14];
    X509 *authority = read_certificate(folder, "permissions_ca.cert.pem");
    const char *fault =
        "no participant: permissions.p7s are not those of cert.pem, a plug-in is missing, or the domain is "
        "full: the log of DDS tells which";
    if (!authority)
        fault = "permissions_ca.cert.pem is no certificate";
    else if (!read_signed(folder, "governance.p7s", authority, text, sizeof text))
        fault = "governance.p7s was changed, or is of another site";
    else if (!read_signed(folder, "permissions.p7s", authority, text, sizeof text))
        fault = "permissions.p7s were changed, or are of another site";
    else if (is_over(text))
        fault = "permissions.p7s have expired: renew them: make_site --renew";
    snprintf(why, why_size, "security = \"%.200s\": %s", folder, fault);
    X509_free(authority);
}
