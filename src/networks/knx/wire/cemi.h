#pragma once

#include <cstdint>
#include <string>

#include "base/bytes.h"
#include "networks/knx/wire/address.h"
#include "rubicon/result.hpp"

namespace rubicon::networks::knx::wire {

/// The service of a group telegram (KNX 3/3/7): APCI 000, 040, 080.
enum class Service : std::uint8_t { kRead, kResponse, kWrite };

/// Numbered as on the wire (KNX 3/6/3, Ctrl1 b3-2). System is the highest, then urgent, normal, low.
enum class Priority : std::uint8_t { kSystem, kNormal, kUrgent, kLow };

/// The value in a telegram. `small`: a value of up to 6 bits that is part of the APCI byte; `bytes` then has one byte
/// of 0..63. Values of 8 bits or more never have this form, even if they would fit.
struct PayloadView {
  ByteView bytes;
  bool small = false;
};

struct Payload {
  Bytes bytes;  ///< at most 253 (kMaxPayload)
  bool small = false;

  operator PayloadView() const { return {bytes, small}; }
  friend bool operator==(const Payload&, const Payload&) = default;
};

/// A telegram to a group address, received or to be sent.
struct Telegram {
  Service service = Service::kWrite;
  GroupAddress destination{};
  Payload payload;             ///< empty in a read
  IndividualAddress source{};  ///< 0.0.0 in a telegram to be sent: the server or the line sets it
  Priority priority = Priority::kLow;
  std::uint8_t hops = 6;  ///< 0..7
  bool repeated = false;  ///< received: a repetition on the bus (Ctrl1 b5 = 0)

  friend bool operator==(const Telegram&, const Telegram&) = default;
};

/// Message codes of cEMI that are used here (KNX 3/6/3); frames may have others.
enum class CemiCode : std::uint8_t {
  kRawRequest = 0x10,
  kDataRequest = 0x11,
  kPollRequest = 0x13,
  kPollConfirmation = 0x25,
  kDataIndication = 0x29,
  kBusMonitor = 0x2b,
  kRawIndication = 0x2d,
  kDataConfirmation = 0x2e,
  kRawConfirmation = 0x2f,
  kResetNotice = 0xf0,
  kResetRequest = 0xf1,
  kPropertyWriteConfirmation = 0xf5,
  kPropertyWrite = 0xf6,
  kPropertyNotice = 0xf7,
  kFunctionCommand = 0xf8,
  kFunctionStateRead = 0xf9,
  kFunctionConfirmation = 0xfa,
  kPropertyReadConfirmation = 0xfb,
  kPropertyRead = 0xfc,
};

/// The fields of an L_Data frame, without the additional info. Refers to the bytes it was read from.
struct DataFrame {
  CemiCode code = CemiCode::kDataRequest;
  std::uint8_t control1 = 0xbc, control2 = 0xe0;
  IndividualAddress source{};
  std::uint16_t destination = 0;
  ByteView tpdu;  ///< from the TPCI byte on, 1..255 bytes

  bool to_group() const { return (control2 & 0x80) != 0; }
  bool extended() const { return (control1 & 0x80) == 0; }
  bool repeated() const { return (control1 & 0x20) == 0; }
  /// Of a confirmation: no device on the bus acknowledged the frame.
  bool failed() const { return (control1 & 0x01) != 0; }
  Priority priority() const { return Priority(control1 >> 2 & 3); }
  std::uint8_t hops() const { return control2 >> 4 & 7; }
  /// Extended frame format 01xx.
  bool lte() const { return (control2 & 0x0c) == 0x04; }
};

/// A frame of L_Data (codes 11, 29, 2E). kInvalid: too short, lengths that do not fit, the escape length 255;
/// kUnsupported: another code. A standard frame may be longer than 15: receivers are tolerant.
Result<DataFrame> read_data_frame(ByteView cemi);
/// Writes the frame without additional info.
Bytes write(const DataFrame& frame);

/// The group telegram in a frame. kUnsupported: an individual or the broadcast address, LTE, a TPCI or APCI other than
/// those of group values.
Result<Telegram> to_telegram(const DataFrame& frame);
/// Both in one.
Result<Telegram> read_telegram(ByteView cemi);

/// Longest payload of an extended frame: 254 bytes after the TPCI, one of them the APCI.
constexpr std::size_t kMaxPayload = 253;
/// Longest payload of a standard frame; devices need not accept more (feature 07, DIB 07).
constexpr std::size_t kMaxStandardPayload = 14;

/// The frame of a telegram, standard or extended according to its length. kOutOfRange: payload too long or empty, hops
/// above 7; kInvalid: the broadcast address, a small payload that is not one byte of 0..63, a read with a payload.
Result<Bytes> write_telegram(CemiCode code, const Telegram& telegram);

/// True if `confirmation` (an L_Data.con) belongs to `request` (the L_Data.req that was sent): they may differ in
/// Ctrl1, additional info, the source if 0.0.0 was sent, and a hop count that is one less (knx.md, section 4). Never
/// fails and never allocates.
bool confirms(ByteView confirmation, ByteView request);
/// Ctrl1 of an L_Data frame; 0 for any other frame.
std::uint8_t control1_of(ByteView cemi);

/// A cEMI frame as readable text in one line: `L_Data.ind low from 1.1.201 to 1/2/5 hops 5 GroupValueResponse (small)
/// 01`. Frames that cannot be read are given in hex with the reason. Never fails.
std::string describe(ByteView cemi, Notation notation = Notation::kThreeLevel);

}  // namespace rubicon::networks::knx::wire
