#include "trust/site/mosquitto_setup.h"

#include <fmt/format.h>

namespace rubicon::trust::site {

namespace {

/// A value of a tuple has at most 1 MiB; its frame has names and numbers besides.
constexpr std::size_t kMessageLimit = 2UL << 20U;

std::string certificates_of(const MosquittoSetup& setup) {
  return fmt::format("certfile {0}/{1}\nkeyfile {0}/{2}\n", setup.folder, kBrokerCertificateFile, kBrokerKeyFile);
}

}  // namespace

std::string mosquitto_conf(const MosquittoSetup& setup) {
  auto text =
      fmt::format("# Written by `rubicon trust broker mosquitto`, which writes it again. Own lines: {}/*.conf\n",
                  kBrokerMoreFolder);
  if (!setup.user.empty()) text += fmt::format("user {}\n", setup.user);
  text +=
      "per_listener_settings false\n"
      "allow_anonymous false\n";
  text += fmt::format("acl_file {}/{}\n", setup.folder, kAclFile);
  if (setup.takes_passwords) text += fmt::format("password_file {}/{}\n", setup.folder, kBrokerPasswordsFile);
  // Whoever is connected writes its presence again after a restart: an interval is enough, and a database that is
  // written at each change would be written for each of a thousand members that come back.
  text += fmt::format(
      "persistence true\n"
      "persistence_location {}/\n"
      "autosave_interval 30\n"
      "autosave_on_changes false\n"
      "max_queued_messages 100000\n"
      "message_size_limit {}\n"
      "set_tcp_nodelay true\n"
      "log_dest stderr\n"
      "log_type error\nlog_type warning\nlog_type notice\n",
      setup.state, kMessageLimit);
  text += fmt::format(
      "\n# Members with a certificate.\n"
      "listener {}\n"
      "cafile {}/{}\n"
      "crlfile {}/{}\n"
      "{}"
      "require_certificate true\n"
      "use_identity_as_username true\n",
      setup.port, setup.folder, kBrokerAuthorityFile, setup.folder, kBrokerRevocationFile, certificates_of(setup));
  if (setup.takes_passwords)
    text += fmt::format("\n# Members with a password.\nlistener {}\n{}", setup.port + 1, certificates_of(setup));
  return text + fmt::format("\ninclude_dir {}/{}\n", setup.folder, kBrokerMoreFolder);
}

std::string mosquitto_acl(const std::set<std::string, std::less<>>& revoked) {
  std::string text =
      "# Written by `rubicon trust`. %u is the user: the name in its certificate, or that with its password.\n"
      "pattern read rubicon-space/1/+/p/#\n"
      "pattern write rubicon-space/1/+/p/+/%u/#\n"
      "pattern read rubicon-space/1/+/to/%u/#\n"
      "pattern write rubicon-space/1/+/to/+/+/%u/+\n";
  for (const auto& user : revoked) text += fmt::format("\nuser {}\ntopic deny #\n", user);
  return text;
}

}  // namespace rubicon::trust::site
