#include "apps/rubicon/doctor/remedies.h"

#include <algorithm>
#include <array>

#include "model/findings.h"

namespace rubicon::cli {

namespace {

using namespace model::findings;

constexpr std::string_view kLines = "errors.md#findings", kSecure = "knx-secure.md#line-states",
                           kRos = "ros2.md#troubles";

constexpr std::array kRemedies{
    Remedy{kHostUnknown, "compare `host` with the name of the server (getent hosts NAME)", kLines,
           "compare `host` with the name of the broker's host (getent hosts NAME)"},
    Remedy{kHostSilent, "the host is off, its name is not found in time, or a firewall drops what comes to that port",
           kLines},
    Remedy{kConnectionRefused, "no program listens there: start the server, or correct `host` and `port`", kLines,
           "no broker listens there: start it (systemctl start rubicon-broker@main), or correct `host` and `port`"},
    Remedy{kCertificateExpired,
           "renew the certificate of the server; if it is valid, check the clock of the island's host (timedatectl)",
           kLines,
           "renew the certificate of the broker (rubicon trust renew broker on the host with the authority); if it is "
           "valid, check the clocks of both hosts (timedatectl)"},
    Remedy{kCertificateEarly,
           "check the clock of the island's host (timedatectl), then the clock of the host that made the certificate "
           "of the server",
           kLines, "check the clocks of both hosts (timedatectl)"},
    Remedy{kCertificateName, "name the server as its certificate does: `host:`, or `tls: {server-name: ...}`", kLines,
           "the broker has a certificate for another name: correct `host`, or on its host `rubicon trust broker "
           "mosquitto --broker NAME`"},
    Remedy{kCertificateAuthority, "name the authority that signed the certificate of the server: `tls: {ca: FILE}`",
           kLines, "`tls: {ca: ...}` has to be the ca.pem of the realm that the broker is of"},
    Remedy{kCertificateBad, "the text says what is wrong with the certificate of the server: replace it", kLines,
           "`tls: {ca: ...}` has to be the ca.pem of the realm that the broker is of; else the clock of one of both "
           "hosts is wrong (timedatectl)"},
    Remedy{kTlsEnds, "the server does not take our certificate, or the port is not one with TLS", kLines,
           "the broker does not take the certificate: it has ended, or was revoked (`rubicon trust show` on the host "
           "with the authority), or the port is that for passwords"},
    Remedy{kTlsExpected, "the server expects TLS, or is no MQTT broker: `tls: {ca: FILE}`, or correct `port`", kLines,
           "`tls: {ca: ..., certificate: ..., key: ...}`, as `rubicon trust join` shows the lines"},
    Remedy{kTlsFailed, "the port is not one with TLS, or the certificate was refused: compare `port`", kLines},
    Remedy{kBrokerSilent, "the broker hangs, or the port is that of another service", kLines},
    Remedy{kLoginRefused,
           "the broker does not know this user, or its password is another one: correct `user` and `password-file`",
           kLines,
           "the broker does not know this user, or its password is another one: compare `user`, and `password-file` "
           "with the phrase of `rubicon trust add`"},
    Remedy{kKeyringUnclear,
           "write the password that was chosen when the keyring was exported into the file of `keyring-password-file`; "
           "if it is that one, export the keyring from ETS again",
           kSecure},
    Remedy{kKeyringPassword,
           "write the password that was chosen when the keyring was exported (not that of the project) into the file "
           "of `keyring-password-file`, and reload",
           kSecure},
    Remedy{kKeyringChanged, "export the keyring from ETS again, and reload", kSecure},
    Remedy{kKeyringPlainTunnels,
           "the project has no secure tunnel: `secure: off` opens a plain one, and secured groups stay secured. If the "
           "interface is secured, activate secure tunnelling in ETS and export the keyring again",
           kSecure},
    Remedy{kPlainLine,
           "nothing, if the interface is plain; `secure: require` forbids plain lines, `secure: off` ends this notice",
           kSecure},
    Remedy{kGroupsReadOnly,
           "sequence numbers need a state file and a clock: configure `state: {file: ...}`, see that the file can be "
           "written, and set the clock of the host",
           kSecure},
    Remedy{kKeyringTunnelsInUse,
           "end another client of the interface, or activate another tunnel in ETS and export the keyring again; the "
           "island keeps trying all of them",
           kSecure},
    Remedy{kKeyringNoTunnel,
           "compare `tunnel-address` and `server-address` with what `rubicon knx keyring FILE` lists; if the tunnel is "
           "missing there, activate secure tunnelling in ETS, download the interface and export the keyring again",
           kSecure},
    Remedy{kKeyringNoUser,
           "set `tunnel-address` to a tunnel that `rubicon knx keyring FILE` lists with a user, or export the keyring "
           "from ETS again",
           kSecure},
    Remedy{kKeyringSeveralInterfaces, "set `server-address` to the individual address of the interface at `host`",
           kSecure},
    Remedy{kKeyringNoBackbone,
           "activate security of the backbone in ETS and export the keyring again, or name a file with the key: "
           "`backbone-key-file`; `secure: allow` makes the line plain",
           kSecure},
    Remedy{kGroupWithoutKey,
           "export the keyring of the whole project from ETS, configure `keyring` and `keyring-password-file` with it, "
           "and reload; if the group is plain by now, import the project again",
           kSecure},
    Remedy{kWrongInterface,
           "check that `host` is the address of that interface; then export the keyring again, or correct "
           "`device-password-file`. Nothing is sent to a device without this proof",
           kSecure},
    Remedy{kUserRefused,
           "the passwords of the tunnels were changed: download the interface in ETS and export the keyring again; "
           "without a keyring correct `user` and `user-password-file`",
           kSecure},
    Remedy{kUserWithoutTunnel, "the tunnels were changed: download the interface in ETS and export the keyring again",
           kSecure},
    Remedy{kConnectionType,
           "`rubicon knx discover --host HOST` shows whether it does; then export a keyring from ETS and configure "
           "`keyring`, `keyring-password-file` and `via: tunnel-tcp`",
           kSecure},
    Remedy{kSessionsInUse, "end another client of the interface (ETS, a visualisation); the island keeps trying",
           kSecure},
    Remedy{kSessionUnanswered,
           "`rubicon knx discover --host HOST` shows whether the interface is secured: if so use `via: tunnel-tcp`, "
           "else activate security in ETS and download it",
           kSecure},
    Remedy{kBackboneOther, "download the routers in ETS, export the keyring again and reload", kSecure},
    Remedy{kBackboneAlone,
           "check `interface`, the multicast address of the backbone in ETS, and that switches pass it on", kSecure},
    Remedy{
        kRosDomainEmpty,
        "start a ROS node, or compare `domain` with its ROS_DOMAIN_ID (`echo $ROS_DOMAIN_ID` there; unset is 0), and "
        "`interfaces` with where robots are: `lo` reaches this host alone",
        kRos},
    Remedy{kRosGidsMixed,
           "give nodes up to Humble and nodes from Iron on a domain each (ROS_DOMAIN_ID, `domain`): in one domain each "
           "kind misreads the names of the other's nodes; topics work all the same",
           kRos},
    Remedy{kRosNamesClash,
           "rename one of the points or its device, or leave one out with `except`: the other one then has the plain "
           "name. `namespace` or another name of one island, if two islands are called alike",
           kRos},
};

}  // namespace

const Remedy* remedy_of(std::string_view finding) {
  const auto found =
      std::find_if(kRemedies.begin(), kRemedies.end(), [&](const Remedy& one) { return one.finding == finding; });
  return found == kRemedies.end() ? nullptr : &*found;
}

std::span<const Remedy> remedies() {
  return kRemedies;
}

}  // namespace rubicon::cli
