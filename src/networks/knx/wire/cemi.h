#pragma once

#include <cstdint>

#include "base/bytes.h"
#include "networks/knx/wire/telegram.h"
#include "rubicon/result.hpp"

namespace rubicon::networks::knx::wire {

/// Message codes of cEMI (KNX 3/6/3). Others occur.
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

/// An L_Data frame taken apart; looks into the bytes it was read from. Additional info was passed over.
struct DataFrame {
  CemiCode code = CemiCode::kDataRequest;
  std::uint8_t control1 = 0xbc, control2 = 0xe0;
  IndividualAddress source{};
  std::uint16_t destination = 0;
  ByteView tpdu;  ///< from the TPCI byte on, 1..255 bytes

  bool to_group() const { return (control2 & 0x80) != 0; }
  bool extended() const { return (control1 & 0x80) == 0; }
  bool repeated() const { return (control1 & 0x20) == 0; }
  /// Of a confirmation: nobody on the bus acknowledged.
  bool failed() const { return (control1 & 0x01) != 0; }
  Priority priority() const { return Priority(control1 >> 2 & 3); }
  std::uint8_t hops() const { return control2 >> 4 & 7; }
  /// Extended frame format 01xx.
  bool lte() const { return (control2 & 0x0c) == 0x04; }
};

/// A frame of L_Data (codes 11, 29, 2E). kInvalid: too short, lengths that do not fit, the escape length 255;
/// kUnsupported: another code. A standard frame may be longer than 15: receivers are tolerant.
Result<DataFrame> read_data_frame(ByteView cemi);
/// As it was read, without additional info.
Bytes write(const DataFrame& frame);

/// What a frame says to a group. kUnsupported: not for a group (an individual or the broadcast address), LTE, another
/// TPCI or APCI than group values; those are for the monitor only.
Result<Telegram> to_telegram(const DataFrame& frame);
/// Both in one.
Result<Telegram> read_telegram(ByteView cemi);

/// Longest payload of an extended frame: 254 bytes behind the TPCI, one of them the APCI.
constexpr std::size_t kMaxPayload = 253;
/// Longest payload of a standard frame; devices need not take more (feature 07, DIB 07).
constexpr std::size_t kMaxStandardPayload = 14;

/// The frame for a telegram, standard or extended as its length asks. kOutOfRange: payload too long or empty, hops
/// above 7; kInvalid: the broadcast address, a small payload that is not one byte of 0..63, a read with a payload.
Result<Bytes> write_telegram(CemiCode code, const Telegram& telegram);

/// True if `confirmation` (an L_Data.con) belongs to `request` (the L_Data.req that was sent): equal but for Ctrl1, the
/// source where 0.0.0 was sent, additional info, and a hop count that is one less (knx.md, section 4). For the hot
/// path: never fails, never allocates.
bool confirms(ByteView confirmation, ByteView request);
/// Ctrl1 of a frame of L_Data, passing over additional info; 0 if there is none.
std::uint8_t control1_of(ByteView cemi);

}  // namespace rubicon::networks::knx::wire
