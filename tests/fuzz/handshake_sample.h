#pragma once

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// How the content reaches Cyclone: in the fragments of packets, in parts that security decoded, or as the hash of a
/// key (16 bytes; missing ones are 0).
enum rubicon_fuzz_way { RUBICON_FUZZ_FRAGMENTS, RUBICON_FUZZ_PARTS, RUBICON_FUZZ_KEY_HASH };

struct rubicon_fuzz_sample {
  enum rubicon_fuzz_way way;
  unsigned kind;    ///< 0 = neither content nor key, 1 = key, 2 = content (enum ddsi_serdata_kind)
  int is_volatile;  ///< of ParticipantVolatileMessageSecure, else of ParticipantStatelessMessage
  size_t piece;     ///< bytes of one fragment or part: at least 4, the header of CDR
  const uint8_t* content;
  size_t size;  ///< 4 to 65000
};

/// What the domain with the guard makes of a sample of a handshake (DDS Security 1.1, 7.4.3 and 7.4.4), read as
/// Cyclone's handlers read it: the sum of its bytes, 0 if it is dropped. Ends the process if there is a sample without
/// a message, which the handlers would read.
uint64_t rubicon_fuzz_take(const struct rubicon_fuzz_sample* sample);

#ifdef __cplusplus
}
#endif
