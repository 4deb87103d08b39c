// To be preloaded into a program: makes DDS fail to create readers.
#include <dds/dds.h>

extern "C" dds_entity_t dds_create_reader(dds_entity_t, dds_entity_t, const dds_qos_t*, const dds_listener_t*) {
  return DDS_RETCODE_OUT_OF_RESOURCES;
}
