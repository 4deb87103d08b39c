#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "base/virtual_scheduler.h"
#include "networks/knx/secure/session.h"
#include "networks/knx/secure/session_channel.h"
#include "networks/knx/secure/vectors.h"

namespace rubicon::networks::knx::secure {

using namespace std::chrono_literals;

/// A client session in virtual time with the keys of the worked vectors (knx.md, section 18); the test is the server.
class SessionFixture : public testing::Test {
 protected:
  SessionFixture() {
    keys.user = 2;
    keys.user_key.key = key_of("43e24ee1095ee6e9483baa42598b4aba");
    keys.device_code = PasswordKey{key_of("e158e4012047bd6cc41aafbc5c04c1fc"), {}};
  }

  /// The bytes that the session asks for, one after another.
  void give_random(const Secret& private_key, const Bytes& serial) {
    random_bytes.assign(private_key.view().begin(), private_key.view().end());
    random_bytes.insert(random_bytes.end(), serial.begin(), serial.end());
  }

  void start() {
    Session::Callbacks calls;
    calls.transmit = [this](ByteView frame) { sent.emplace_back(frame.begin(), frame.end()); };
    calls.up = [this] { ++ups; };
    calls.received = [this](ByteView frame) { received.emplace_back(frame.begin(), frame.end()); };
    calls.note = [this](const std::string& subject, std::string_view text) {
      notes.push_back(subject + ": " + std::string(text));
    };
    calls.ended = [this](Session::End end) { ends.push_back(std::move(end)); };
    settings.random = [this](std::span<std::uint8_t> bytes) -> Result<void> {
      if (random_bytes.size() < bytes.size()) return fail(ErrorCode::kIo, "no more random bytes");
      std::copy_n(random_bytes.begin(), bytes.size(), bytes.begin());
      random_bytes.erase(random_bytes.begin(), random_bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size()));
      return {};
    };
    session = std::make_unique<Session>(time, keys, settings, counters, std::move(calls));
    session->start();
  }

  std::string last_sent() const { return sent.empty() ? "" : base::to_hex(sent.back()); }

  VirtualScheduler time;
  SessionKeys keys;
  Session::Settings settings{false, {wire::HostProtocol::kTcp, {}, 0}, false, false, {}};
  SessionCounters counters;
  Bytes random_bytes;
  std::vector<Bytes> sent, received;
  std::vector<std::string> notes;
  std::vector<Session::End> ends;
  int ups = 0;
  std::unique_ptr<Session> session;
};

}  // namespace rubicon::networks::knx::secure
