#include "tuples/dds/shield.h"

#include <arpa/inet.h>
#include <dds/dds.h>
#include <dds/ddsi/ddsi_guid.h>
#include <dds/ddsi/ddsi_vendor.h>
#include <dlfcn.h>

#include <algorithm>
#include <cstring>
#include <mutex>
#include <vector>

#include "base/assert.h"

// As dds/ddsi/ddsi_proxy_participant.h and q_addrset.h of 0.10 declare them; C++ cannot read those headers.
struct ddsi_domaingv;
struct ddsi_plist;
struct addrset;
extern "C" {
DDS_EXPORT void unref_addrset(addrset* addresses);
DDS_EXPORT int ddsi_delete_proxy_participant_by_guid(ddsi_domaingv* gv, const ddsi_guid* guid, ddsrt_wctime_t timestamp,
                                                     int isimplicit);
DDS_EXPORT bool ddsi_new_proxy_participant(ddsi_domaingv* gv, const ddsi_guid* guid, std::uint32_t bes,
                                           const ddsi_guid* privileged_pp_guid, addrset* as_default, addrset* as_meta,
                                           const ddsi_plist* plist, dds_duration_t tlease_dur, nn_vendorid_t vendor,
                                           unsigned custom_flags, ddsrt_wctime_t timestamp, std::uint64_t seq);
}

namespace rubicon::tuples::dds {

namespace {

constexpr unsigned kIsService = 1U << 1U;  // CF_PARTICIPANT_IS_DDSI2

struct Shields {
  std::mutex mutex;
  std::vector<const DdsTrust*> all;
};

Shields& shields() {
  static Shields one;
  return one;
}

GuidPrefix prefix_on_wire(const ddsi_guid& guid) {
  GuidPrefix prefix{};
  for (std::size_t i = 0; i < std::size(guid.prefix.u); ++i) {
    const auto word = htonl(guid.prefix.u[i]);
    std::memcpy(prefix.data() + i * sizeof word, &word, sizeof word);
  }
  return prefix;
}

bool is_member(const ddsi_guid& guid) {
  auto& [mutex, all] = shields();
  const std::lock_guard lock(mutex);
  const auto prefix = prefix_on_wire(guid);
  return std::any_of(all.begin(), all.end(), [&](const DdsTrust* trust) { return trust->who(prefix).has_value(); });
}

bool has_shields() {
  auto& [mutex, all] = shields();
  const std::lock_guard lock(mutex);
  return !all.empty();
}

/// The function of Cyclone that one of ours stands before.
template <class Function>
Function* behind(const char* name) {
  auto* found = ::dlsym(RTLD_NEXT, name);
  RUBICON_ASSERT(found != nullptr);
  return reinterpret_cast<Function*>(found);
}

}  // namespace

Shield::Shield(std::shared_ptr<const DdsTrust> trust) : trust_(std::move(trust)) {
  auto& [mutex, all] = shields();
  const std::lock_guard lock(mutex);
  all.push_back(trust_.get());
}

Shield::~Shield() {
  auto& [mutex, all] = shields();
  const std::lock_guard lock(mutex);
  all.erase(std::find(all.begin(), all.end(), trust_.get()));
}

bool Shield::is_first() {
  Dl_info found{}, own{};
  const auto* first = ::dlsym(RTLD_DEFAULT, "ddsi_delete_proxy_participant_by_guid");
  return ::dladdr(first, &found) != 0 && ::dladdr(reinterpret_cast<const void*>(&Shield::is_first), &own) != 0 &&
         found.dli_fbase == own.dli_fbase;
}

}  // namespace rubicon::tuples::dds

extern "C" {

/// `isimplicit`: Cyclone itself decided that, by a lease or because the certificate ended.
int ddsi_delete_proxy_participant_by_guid(ddsi_domaingv* gv, const ddsi_guid* guid, ddsrt_wctime_t timestamp,
                                          int isimplicit) {
  namespace dds = rubicon::tuples::dds;
  static const auto real =
      dds::behind<decltype(ddsi_delete_proxy_participant_by_guid)>("ddsi_delete_proxy_participant_by_guid");
  if (isimplicit == 0 && dds::is_member(*guid)) return DDS_RETCODE_OK;
  return real(gv, guid, timestamp, isimplicit);
}

/// With trust there are no services that others depend on. It owns both sets of addresses.
bool ddsi_new_proxy_participant(ddsi_domaingv* gv, const ddsi_guid* guid, std::uint32_t bes,
                                const ddsi_guid* privileged_pp_guid, addrset* as_default, addrset* as_meta,
                                const ddsi_plist* plist, dds_duration_t tlease_dur, nn_vendorid_t vendor,
                                unsigned custom_flags, ddsrt_wctime_t timestamp, std::uint64_t seq) {
  namespace dds = rubicon::tuples::dds;
  static const auto real = dds::behind<decltype(ddsi_new_proxy_participant)>("ddsi_new_proxy_participant");
  const auto& service = privileged_pp_guid->prefix.u;
  const bool has_service = (custom_flags & dds::kIsService) != 0 ||
                           std::any_of(std::begin(service), std::end(service), [](auto word) { return word != 0; });
  if (has_service && dds::has_shields()) {
    unref_addrset(as_default);
    unref_addrset(as_meta);
    return false;
  }
  return real(gv, guid, bes, privileged_pp_guid, as_default, as_meta, plist, tlease_dur, vendor, custom_flags,
              timestamp, seq);
}

}  // extern "C"
