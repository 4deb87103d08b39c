// A participant with certificates, for the tests of the guard: writes and reads frames in partitions, and says on
// standard output what it got of whom, and whom its guard refused. Commands on standard input: `who`, `revoke SERIAL`,
// `memory`, `quit`.
#include <dds/dds.h>
#include <dlfcn.h>
#include <malloc.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "trust/guard/guard.h"
#include "wire.h"

namespace {

struct Guard {
  decltype(&rubicon_guard_who) who = nullptr;
  decltype(&rubicon_guard_revoke) revoke = nullptr;
  decltype(&rubicon_guard_watch) watch = nullptr;
};

struct Options {
  std::string documents;
  std::string library;                    ///< of all three plug-ins; empty = the built-in ones
  std::string symbols = "rubicon_guard";  ///< beginning of the names of its functions
  std::string text;                       ///< what it writes
  std::vector<std::string> writes, reads;
  int participants = 1;
};

void say(const std::string& line) {
  const auto whole = line + "\n";
  if (::write(1, whole.data(), whole.size()) < 0) ::_exit(1);
}

std::string hexadecimal(const std::uint8_t* bytes, std::size_t size) {
  std::string text;
  for (std::size_t i = 0; i < size; ++i) {
    char two[3];
    std::snprintf(two, sizeof two, "%02x", bytes[i]);
    text += two;
  }
  return text;
}

Options options_of(int count, char** arguments) {
  Options options;
  for (int i = 1; i + 1 < count; i += 2) {
    const std::string name = arguments[i], value = arguments[i + 1];
    if (name == "--documents") options.documents = value;
    if (name == "--library") options.library = value;
    if (name == "--symbols") options.symbols = value;
    if (name == "--text") options.text = value;
    if (name == "--write") options.writes.push_back(value);
    if (name == "--read") options.reads.push_back(value);
    if (name == "--participants") options.participants = std::stoi(value);
  }
  return options;
}

dds_qos_t* security(const Options& options) {
  auto* qos = dds_create_qos();
  const auto set = [&](const std::string& name, const std::string& value) {
    dds_qset_prop(qos, ("dds.sec." + name).c_str(), value.c_str());
  };
  const auto plugin = [&](const std::string& name, const std::string& builtin, const std::string& function) {
    const bool own = !options.library.empty();
    set(name + ".library.path", own ? options.library : builtin);
    set(name + ".library.init", own ? options.symbols + "_init_" + function : "init_" + function);
    set(name + ".library.finalize", own ? options.symbols + "_finalize_" + function : "finalize_" + function);
  };
  plugin("auth", "dds_security_auth", "authentication");
  plugin("access", "dds_security_ac", "access_control");
  plugin("crypto", "dds_security_crypto", "crypto");
  const auto file = [&](const char* name) { return "file:" + options.documents + "/" + name; };
  set("auth.identity_ca", file("identity-ca.pem"));
  set("auth.identity_certificate", file("certificate.pem"));
  set("auth.private_key", file("key.pem"));
  set("access.permissions_ca", file("permissions-ca.pem"));
  set("access.governance", file("governance.p7s"));
  set("access.permissions", file("permissions.p7s"));
  return qos;
}

Guard open_guard(const Options& options) {
  Guard guard;
  void* handle = options.library.empty() ? nullptr : ::dlopen(options.library.c_str(), RTLD_NOW | RTLD_NOLOAD);
  if (handle == nullptr) return guard;
  guard.who = reinterpret_cast<decltype(guard.who)>(::dlsym(handle, "rubicon_guard_who"));
  guard.revoke = reinterpret_cast<decltype(guard.revoke)>(::dlsym(handle, "rubicon_guard_revoke"));
  guard.watch = reinterpret_cast<decltype(guard.watch)>(::dlsym(handle, "rubicon_guard_watch"));
  return guard;
}

void refused(void*, const std::uint8_t prefix[12], const char* name, int is_verified, const char* reason) {
  say("refused " + std::string(*name == '\0' ? "-" : name) + " " + hexadecimal(prefix, 12) +
      (is_verified != 0 ? " verified " : " claimed ") + reason);
}

class Member {
 public:
  explicit Member(Options options) : options_(std::move(options)) {
    const std::string xml =
        "<CycloneDDS><Domain Id=\"any\"><General><Interfaces><NetworkInterface name=\"lo\" multicast=\"true\"/>"
        "</Interfaces><AllowMulticast>spdp</AllowMulticast></General><Discovery><ParticipantIndex>none</"
        "ParticipantIndex>"
        "<LeaseDuration>4 s</LeaseDuration><SPDPInterval>1 s</SPDPInterval></Discovery></Domain></CycloneDDS>";
    dds_create_domain(0, xml.c_str());
  }

  /// False: DDS made no participant.
  bool join() {
    auto* qos = security(options_);
    participant_ = dds_create_participant(0, qos, nullptr);
    for (int i = 1; i < options_.participants; ++i) dds_create_participant(0, qos, nullptr);
    dds_delete_qos(qos);
    if (participant_ < 0) return false;
    guard_ = open_guard(options_);
    if (guard_.watch != nullptr) guard_.watch(refused, nullptr);
    topic_ = dds_create_topic(participant_, &rubicon_wire_Frame_desc, "rubicon_frames", nullptr, nullptr);
    for (const auto& partition : options_.writes) make_writer(partition);
    for (const auto& partition : options_.reads) make_reader(partition);
    dds_guid_t guid{};
    dds_get_guid(participant_, &guid);
    say("joined " + hexadecimal(guid.v, 12));
    return true;
  }

  void leave() {
    if (guard_.watch != nullptr) guard_.watch(nullptr, nullptr);
    dds_delete(DDS_CYCLONEDDS_HANDLE);
  }

  void turn() {
    for (const auto& [partition, writer] : writers_) {
      tell("readers", partition, matched(writer, &dds_get_publication_matched_status));
      rubicon_wire_Frame frame{};
      frame.content._length = frame.content._maximum = static_cast<std::uint32_t>(options_.text.size());
      frame.content._buffer = reinterpret_cast<std::uint8_t*>(options_.text.data());
      dds_write(writer, &frame);
    }
    for (const auto& [partition, reader] : readers_) {
      tell("writers", partition, matched(reader, &dds_get_subscription_matched_status));
      take(partition, reader);
    }
  }

  /// False: it is to end.
  bool obey(const std::string& line) {
    std::istringstream words(line);
    std::string verb, argument;
    words >> verb >> argument;
    if (verb == "who") show_who();
    if (verb == "revoke" && guard_.revoke != nullptr) {
      const char* serial = argument.c_str();
      guard_.revoke(&serial, 1);
      say("revoked");
    }
    if (verb == "memory") show_memory();
    if (verb == "again") heard_.clear();
    return verb != "quit";
  }

 private:
  static dds_qos_t* reliable() {
    auto* qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1);
    return qos;
  }

  void make_writer(const std::string& partition) {
    auto* in = dds_create_qos();
    dds_qset_partition1(in, partition.c_str());
    auto* qos = reliable();
    const auto publisher = dds_create_publisher(participant_, in, nullptr);
    const auto writer = dds_create_writer(publisher, topic_, qos, nullptr);
    if (writer < 0) say("no-writer " + partition);
    if (writer >= 0) writers_.emplace_back(partition, writer);
    dds_delete_qos(qos);
    dds_delete_qos(in);
  }

  void make_reader(const std::string& partition) {
    auto* in = dds_create_qos();
    dds_qset_partition1(in, partition.c_str());
    auto* qos = reliable();
    const auto subscriber = dds_create_subscriber(participant_, in, nullptr);
    const auto reader = dds_create_reader(subscriber, topic_, qos, nullptr);
    if (reader < 0) say("no-reader " + partition);
    if (reader >= 0) readers_.emplace_back(partition, reader);
    dds_delete_qos(qos);
    dds_delete_qos(in);
  }

  template <class Status>
  static std::uint32_t matched(dds_entity_t endpoint, dds_return_t (*ask)(dds_entity_t, Status*)) {
    Status status{};
    ask(endpoint, &status);
    return status.current_count;
  }

  void tell(const std::string& what, const std::string& partition, std::uint32_t count) {
    auto& former = counts_[what + " " + partition];
    if (former != count) say(what + " " + partition + " " + std::to_string(count));
    former = count;
  }

  void take(const std::string& partition, dds_entity_t reader) {
    void* samples[8] = {};
    dds_sample_info_t infos[8];
    const auto count = dds_take(reader, samples, infos, 8, 8);
    for (int i = 0; i < count; ++i) {
      if (!infos[i].valid_data) continue;
      const auto& content = static_cast<const rubicon_wire_Frame*>(samples[i])->content;
      const std::string text(reinterpret_cast<const char*>(content._buffer), content._length);
      got(partition, text, reader, infos[i].publication_handle);
    }
    if (count > 0) dds_return_loan(reader, samples, count);
  }

  void got(const std::string& partition, const std::string& text, dds_entity_t reader, dds_instance_handle_t from) {
    if (!heard_.insert(partition + " " + text).second) return;
    say("got " + partition + " " + text);
    auto* publication = dds_get_matched_publication_data(reader, from);
    if (publication == nullptr) return;
    Prefix prefix{};
    std::copy_n(publication->participant_key.v, prefix.size(), prefix.begin());
    dds_builtintopic_free_endpoint(publication);
    met_.insert(prefix);
    show_who();
  }

  void show_who() {
    for (const auto& prefix : met_) {
      rubicon_guard_peer peer{};
      if (guard_.who == nullptr || guard_.who(prefix.data(), &peer) == 0) {
        say("nobody " + hexadecimal(prefix.data(), prefix.size()));
        continue;
      }
      say("who " + std::string(peer.name) + " " + peer.ids + " " + (*peer.roles == '\0' ? "-" : peer.roles) + " " +
          peer.serial + " " + std::to_string(peer.expires));
    }
  }

  static void show_memory() {
    ::malloc_trim(0);
    std::ifstream file("/proc/self/statm");
    long all = 0, resident = 0;
    file >> all >> resident;
    say("memory " + std::to_string(resident * ::sysconf(_SC_PAGESIZE) / 1024));
  }

  using Prefix = std::array<std::uint8_t, 12>;

  Options options_;
  Guard guard_;
  dds_entity_t participant_ = 0, topic_ = 0;
  std::vector<std::pair<std::string, dds_entity_t>> writers_, readers_;
  std::map<std::string, std::uint32_t> counts_;
  std::set<std::string> heard_;
  std::set<Prefix> met_;
};

}  // namespace

int main(int count, char** arguments) {
  auto options = options_of(count, arguments);
  // Cyclone logs each refusal: a pipe that nobody reads would stop it.
  if (std::freopen((options.documents + "/log").c_str(), "w", stderr) == nullptr) return 1;
  Member member(std::move(options));
  if (!member.join()) {
    say("not-joined");
    return 1;
  }
  constexpr int kTurnMs = 20;
  std::string pending;
  while (true) {
    pollfd input{0, POLLIN, 0};
    if (::poll(&input, 1, kTurnMs) > 0) {
      char buffer[256];
      const auto size = ::read(0, buffer, sizeof buffer);
      if (size <= 0) break;
      pending.append(buffer, static_cast<std::size_t>(size));
      while (pending.find('\n') != pending.npos) {
        const auto line = pending.substr(0, pending.find('\n'));
        pending.erase(0, line.size() + 1);
        if (!member.obey(line)) {
          member.leave();
          return 0;
        }
      }
    }
    member.turn();
  }
  member.leave();
  return 0;
}
