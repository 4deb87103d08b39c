#include "model/message.h"

namespace rubicon::model {

std::string_view to_string(Outcome outcome) {
  switch (outcome) {
    case Outcome::kSent: return "sent";
    case Outcome::kFailed: return "failed";
    case Outcome::kUnsupported: return "unsupported";
    case Outcome::kUndeliverable: return "undeliverable";
    case Outcome::kRefused: return "refused";
    case Outcome::kBusy: return "busy";
  }
  return "unknown";
}

std::string_view to_string(LineState state) {
  switch (state) {
    case LineState::kDown: return "down";
    case LineState::kConnecting: return "connecting";
    case LineState::kUp: return "up";
    case LineState::kEnded: return "ended";
    case LineState::kRefused: return "refused";
  }
  return "unknown";
}

std::string_view to_string(MessageKind kind) {
  switch (kind) {
    case MessageKind::kJoin: return "join";
    case MessageKind::kKeepAlive: return "keepalive";
    case MessageKind::kLeave: return "leave";
    case MessageKind::kUpdates: return "updates";
    case MessageKind::kActuate: return "actuate";
    case MessageKind::kSample: return "sample";
    case MessageKind::kSetProperty: return "set-property";
    case MessageKind::kAcknowledge: return "acknowledge";
    case MessageKind::kState: return "state";
    case MessageKind::kOpaque: return "opaque";
    case MessageKind::kProbe: return "probe";
    case MessageKind::kUnreachable: return "unreachable";
  }
  return "unknown";
}

}  // namespace rubicon::model
