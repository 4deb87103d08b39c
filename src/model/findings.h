#pragma once

#include <string_view>

/// Words for reasons that have a remedy: `Error::finding`, and the member `finding` of the status of a line. Programs
/// compare them, people read the text beside them. `rubicon doctor` has a remedy for each, docs/errors.md lists them.
namespace rubicon::model::findings {

// Servers that a line connects to, and TLS.
inline constexpr std::string_view kHostUnknown = "host-unknown";
inline constexpr std::string_view kHostSilent = "host-silent";
inline constexpr std::string_view kConnectionRefused = "connection-refused";
inline constexpr std::string_view kCertificateExpired = "certificate-expired";
inline constexpr std::string_view kCertificateEarly = "certificate-early";
inline constexpr std::string_view kCertificateName = "certificate-name";
inline constexpr std::string_view kCertificateAuthority = "certificate-authority";
inline constexpr std::string_view kCertificateBad = "certificate-bad";
inline constexpr std::string_view kTlsEnds = "tls-ends";
inline constexpr std::string_view kTlsExpected = "tls-expected";
inline constexpr std::string_view kTlsFailed = "tls-failed";
inline constexpr std::string_view kBrokerSilent = "broker-silent";
inline constexpr std::string_view kLoginRefused = "login-refused";

// KNX Secure (docs/knx-secure.md).
inline constexpr std::string_view kKeyringPassword = "keyring-password";
inline constexpr std::string_view kKeyringUnclear = "keyring-unclear";
inline constexpr std::string_view kKeyringChanged = "keyring-changed";
inline constexpr std::string_view kKeyringPlainTunnels = "keyring-plain-tunnels";
inline constexpr std::string_view kKeyringTunnelsInUse = "keyring-tunnels-in-use";
inline constexpr std::string_view kKeyringNoTunnel = "keyring-no-tunnel";
inline constexpr std::string_view kKeyringNoUser = "keyring-no-user";
inline constexpr std::string_view kKeyringSeveralInterfaces = "keyring-several-interfaces";
inline constexpr std::string_view kKeyringNoBackbone = "keyring-no-backbone";
inline constexpr std::string_view kPlainLine = "plain-line";
inline constexpr std::string_view kGroupsReadOnly = "groups-read-only";
inline constexpr std::string_view kGroupWithoutKey = "group-without-key";
inline constexpr std::string_view kWrongInterface = "wrong-interface";
inline constexpr std::string_view kUserRefused = "user-refused";
inline constexpr std::string_view kUserWithoutTunnel = "user-without-tunnel";
inline constexpr std::string_view kConnectionType = "connection-type";
inline constexpr std::string_view kSessionsInUse = "sessions-in-use";
inline constexpr std::string_view kSessionUnanswered = "session-unanswered";
inline constexpr std::string_view kBackboneOther = "backbone-other";
inline constexpr std::string_view kBackboneAlone = "backbone-alone";

// ROS 2 (docs/ros2.md).
inline constexpr std::string_view kRosDomainEmpty = "ros-domain-empty";
inline constexpr std::string_view kRosGidsMixed = "ros-gids-mixed";
inline constexpr std::string_view kRosNamesClash = "ros-names-clash";

}  // namespace rubicon::model::findings
