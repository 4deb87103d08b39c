#include "handshake_sample.h"

#include <dds/ddsi/ddsi_domaingv.h>
#include <dds/ddsi/ddsi_security_msg.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_serdata_pserop.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <dds/ddsi/q_radmin.h>
#include <stdlib.h>
#include <string.h>

#include "trust/guard/data_only.h"

// A file of C: C++ cannot read ddsi_domaingv.h.

enum { kPieces = 32 };

/// As q_init.c of Cyclone DDS 0.10.2 makes it (make_special_type_pserop).
static struct ddsi_sertype* type_of_messages(const char* name) {
  struct ddsi_sertype_pserop* type = calloc(1, sizeof *type);
  ddsi_sertype_init(&type->c, name, &ddsi_sertype_ops_pserop, &ddsi_serdata_ops_pserop, true);
  type->encoding_format = CDR_ENC_FORMAT_PLAIN;
  type->memsize = sizeof(nn_participant_generic_message_t);
  type->nops = pserop_participant_generic_message_nops;
  type->ops = pserop_participant_generic_message;
  return &type->c;
}

static const struct ddsi_domaingv* guarded_domain(void) {
  static struct ddsi_domaingv* domain;
  if (domain) return domain;
  domain = calloc(1, sizeof *domain);
  domain->pgm_stateless_type = type_of_messages("ParticipantStatelessMessage");
  domain->pgm_volatile_type = type_of_messages("ParticipantVolatileMessageSecure");
  rubicon_guard_take_data_only(domain);
  return domain;
}

/// The size of the next piece: the last one takes the rest.
static size_t next_piece(const struct rubicon_fuzz_sample* sample, size_t at, size_t index) {
  const size_t rest = sample->size - at;
  return index + 1 == kPieces || sample->piece > rest ? rest : sample->piece;
}

/// Each fragment in a packet of its own.
static struct ddsi_serdata* from_fragments(const struct ddsi_sertype* type, const struct rubicon_fuzz_sample* sample) {
  struct nn_rdata fragments[kPieces];
  memset(fragments, 0, sizeof fragments);
  size_t count = 0;
  for (size_t at = 0; at < sample->size; ++count) {
    const size_t size = next_piece(sample, at, count);
    struct nn_rdata* one = &fragments[count];
    one->rmsg = calloc(1, sizeof *one->rmsg + size);
    memcpy(NN_RMSG_PAYLOAD(one->rmsg), sample->content + at, size);
    one->min = (uint32_t)at;
    one->maxp1 = (uint32_t)(at + size);
    if (count > 0) fragments[count - 1].nextfrag = one;
    at += size;
  }
  struct ddsi_serdata* taken =
      ddsi_serdata_from_ser(type, (enum ddsi_serdata_kind)sample->kind, fragments, sample->size);
  for (size_t i = 0; i < count; ++i) free(fragments[i].rmsg);
  return taken;
}

static struct ddsi_serdata* from_parts(const struct ddsi_sertype* type, const struct rubicon_fuzz_sample* sample) {
  ddsrt_iovec_t parts[kPieces];
  size_t count = 0;
  for (size_t at = 0; at < sample->size; ++count) {
    parts[count].iov_len = (ddsrt_iov_len_t)next_piece(sample, at, count);
    parts[count].iov_base = (void*)(sample->content + at);
    at += parts[count].iov_len;
  }
  return ddsi_serdata_from_ser_iov(type, (enum ddsi_serdata_kind)sample->kind, (ddsrt_msg_iovlen_t)count, parts,
                                   sample->size);
}

static struct ddsi_serdata* from_key_hash(const struct ddsi_sertype* type, const struct rubicon_fuzz_sample* sample) {
  ddsi_keyhash_t hash;
  memset(&hash, 0, sizeof hash);
  memcpy(hash.value, sample->content, sample->size < sizeof hash.value ? sample->size : sizeof hash.value);
  return ddsi_serdata_from_keyhash(type, &hash);
}

static uint64_t sum_of(const void* bytes, size_t size) {
  uint64_t sum = size;
  for (size_t i = 0; i < size; ++i) sum += ((const unsigned char*)bytes)[i];
  return sum;
}

static uint64_t sum_of_text(const char* text) {
  return text ? sum_of(text, strlen(text)) : 0;
}

static uint64_t sum_of_holder(const nn_dataholder_t* holder) {
  uint64_t sum = sum_of_text(holder->class_id);
  for (uint32_t i = 0; i < holder->properties.n; ++i) {
    const dds_property_t* one = &holder->properties.props[i];
    sum += sum_of_text(one->name) + sum_of_text(one->value);
  }
  for (uint32_t i = 0; i < holder->binary_properties.n; ++i) {
    const dds_binaryproperty_t* one = &holder->binary_properties.props[i];
    sum += sum_of_text(one->name) + sum_of(one->value.value, one->value.length);
  }
  return sum;
}

/// All that handle_auth_handshake_message and handle_crypto_exchange_message of ddsi_security_exchange.c may read.
static uint64_t read_as_handlers(const struct ddsi_serdata* taken) {
  const nn_participant_generic_message_t* message = ((const struct ddsi_serdata_pserop*)taken)->sample;
  if (taken->kind != SDK_DATA || !message) abort();
  uint64_t sum = 1 + sum_of(&message->message_identity, sizeof message->message_identity) +
                 sum_of(&message->related_message_identity, sizeof message->related_message_identity) +
                 sum_of_text(message->message_class_id);
  for (uint32_t i = 0; i < message->message_data.n; ++i) sum += sum_of_holder(&message->message_data.tags[i]);
  return sum;
}

uint64_t rubicon_fuzz_take(const struct rubicon_fuzz_sample* sample) {
  const struct ddsi_domaingv* domain = guarded_domain();
  const struct ddsi_sertype* type = sample->is_volatile ? domain->pgm_volatile_type : domain->pgm_stateless_type;
  struct ddsi_serdata* taken = sample->way == RUBICON_FUZZ_FRAGMENTS ? from_fragments(type, sample)
                               : sample->way == RUBICON_FUZZ_PARTS   ? from_parts(type, sample)
                                                                     : from_key_hash(type, sample);
  if (!taken) return 0;
  const uint64_t sum = read_as_handlers(taken);
  ddsi_serdata_unref(taken);
  return sum;
}
