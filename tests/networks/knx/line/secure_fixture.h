#pragma once

#include "networks/knx/line/line_fixture.h"

namespace rubicon::networks::knx::line {

/// A tunnel through KNX IP Secure to a simulated server that takes nothing else.
class SecureFixture : public LineFixture {
 protected:
  SecureFixture() {
    secured.device_code = key(0xd0);
    secured.users = {{2, key(2), 0}, {3, key(3), 0x11c9}};
    options.via = TunnelOptions::Via::kTcp;
    options.secure = secure::SessionKeys{2, {key(2), {}}, secure::PasswordKey{key(0xd0), {}}};
  }

  static secure::Key key(std::uint8_t first) {
    secure::Key made;
    for (auto& byte : made.span()) byte = first++;
    return made;
  }

  void make_secure_server() {
    with.secure = secured;
    make_server(with);
  }
  void connect_secure() {
    if (!server) make_secure_server();
    connect();
  }
  /// Opens without waiting for more than a moment.
  void open() {
    if (!server) make_secure_server();
    make_line();
    ASSERT_TRUE(line->open());
    time.run_for(100ms);
  }
  const std::string& reason() const { return line->state().reason; }
  std::size_t sessions() { return server->sessions()->size(); }

  knx_simulator::SecureOptions secured;
  support::KnxServer::Options with;
};

}  // namespace rubicon::networks::knx::line
