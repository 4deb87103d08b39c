#include "trust/guard/data_only.h"

#include <dds/ddsi/ddsi_domaingv.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_serdata_pserop.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <pthread.h>

// A file of C: C++ cannot read ddsi_domaingv.h.

static struct ddsi_serdata_ops operations;
static pthread_once_t once = PTHREAD_ONCE_INIT;

static struct ddsi_serdata* from_ser(const struct ddsi_sertype* type, enum ddsi_serdata_kind kind,
                                     const struct nn_rdata* fragments, size_t size) {
  return kind == SDK_DATA ? ddsi_serdata_ops_pserop.from_ser(type, kind, fragments, size) : NULL;
}

static struct ddsi_serdata* from_ser_iov(const struct ddsi_sertype* type, enum ddsi_serdata_kind kind,
                                         ddsrt_msg_iovlen_t count, const ddsrt_iovec_t* parts, size_t size) {
  return kind == SDK_DATA ? ddsi_serdata_ops_pserop.from_ser_iov(type, kind, count, parts, size) : NULL;
}

static struct ddsi_serdata* from_keyhash(const struct ddsi_sertype* type, const struct ddsi_keyhash* hash) {
  (void)type;
  (void)hash;
  return NULL;
}

static void set_operations(void) {
  operations = ddsi_serdata_ops_pserop;
  operations.from_ser = from_ser;
  operations.from_ser_iov = from_ser_iov;
  operations.from_keyhash = from_keyhash;
}

void rubicon_guard_take_data_only(struct ddsi_domaingv* domain) {
  pthread_once(&once, set_operations);
  struct ddsi_sertype* const types[] = {domain->pgm_stateless_type, domain->pgm_volatile_type};
  for (size_t i = 0; i < sizeof types / sizeof *types; ++i) {
    if (types[i]->serdata_ops == &ddsi_serdata_ops_pserop) types[i]->serdata_ops = &operations;
  }
}
