/* An access-control plug-in that lets its own program do everything, and is Cyclone's own (named by LAWFUL) in all
 * else: what a client might run that does not keep to its permissions. */
#include <dds/security/dds_security_api.h>
#include <dlfcn.h>
#include <stdlib.h>

int init_access_control(const char *argument, void **context, struct ddsi_domaingv *gv);
int finalize_access_control(void *context);

static void *lawful;

static DDS_Security_boolean write_anything(dds_security_access_control *self,
    const DDS_Security_PermissionsHandle handle, const DDS_Security_DomainId domain, const DDS_Security_char *topic,
    const DDS_Security_Qos *qos, const DDS_Security_PartitionQosPolicy *partition, const DDS_Security_DataTags *tags,
    DDS_Security_SecurityException *exception)
{
    (void)self, (void)handle, (void)domain, (void)topic, (void)qos, (void)partition, (void)tags, (void)exception;
    return true;
}

static DDS_Security_boolean any_topic(dds_security_access_control *self, const DDS_Security_PermissionsHandle handle,
    const DDS_Security_DomainId domain, const DDS_Security_char *topic, const DDS_Security_Qos *qos,
    DDS_Security_SecurityException *exception)
{
    (void)self, (void)handle, (void)domain, (void)topic, (void)qos, (void)exception;
    return true;
}

int init_access_control(const char *argument, void **context, struct ddsi_domaingv *gv)
{
    const char *path = getenv("LAWFUL");
    lawful = path ? dlopen(path, RTLD_NOW) : NULL;
    plugin_init init = lawful ? (plugin_init)dlsym(lawful, "init_access_control") : NULL;
    if (!init || init(argument, context, gv) != 0) return -1;
    dds_security_access_control *control = *context;
    control->check_create_datawriter = write_anything;
    control->check_create_topic = any_topic;
    return 0;
}

int finalize_access_control(void *context)
{
    plugin_finalize finalize = (plugin_finalize)dlsym(lawful, "finalize_access_control");
    return finalize(context);
}
