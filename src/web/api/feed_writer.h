#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/tuple.hpp"

namespace rubicon::web::api {

/// Writes what a Feed has to send as one frame after another.
class FeedWriter {
 public:
  virtual ~FeedWriter() = default;

  /// The form of a set; the tuple is only valid during the call.
  virtual std::string update(const TupleView& tuple) const = 0;

  // -- the parts of a frame, in this order
  virtual void presence(const std::vector<OwnerId>& owners, bool absent) = 0;
  /// `update` is what update() returned; `introduce` = the client does not know the number of the key yet.
  virtual void set(OwnerId owner, std::string_view key, std::uint32_t number, bool introduce,
                   std::string_view update) = 0;
  virtual void gone(OwnerId owner, std::string_view key, std::uint32_t number, EventKind how) = 0;
  /// Nothing follows it in this frame.
  virtual void snapshot(OwnerId owner) = 0;
  /// Bytes of the frame so far.
  virtual std::size_t size() const = 0;
  /// The frame; the next one begins. Empty if it had no parts.
  virtual std::string finish() = 0;

  /// A frame of its own: so many events were dropped.
  virtual std::string lost(std::uint64_t events) = 0;
};

/// Frames of a WebSocket (docs/api.md): JSON, with numbers for keys.
class SocketWriter final : public FeedWriter {
 public:
  SocketWriter(unsigned subscription, bool full) : subscription_(subscription), full_(full) {}

  std::string update(const TupleView& tuple) const override;
  void presence(const std::vector<OwnerId>& owners, bool absent) override;
  void set(OwnerId owner, std::string_view key, std::uint32_t number, bool introduce, std::string_view update) override;
  void gone(OwnerId owner, std::string_view key, std::uint32_t number, EventKind how) override;
  void snapshot(OwnerId owner) override;
  std::size_t size() const override { return head_.size() + keys_.size() + sets_.size() + gone_.size(); }
  std::string finish() override;
  std::string lost(std::uint64_t events) override;

 private:
  unsigned subscription_;
  bool full_;
  std::string head_, keys_, sets_, gone_, tail_;
};

/// Server-sent events (HTML standard, section 9.2): one for each tuple, with the names of the command line.
class StreamWriter final : public FeedWriter {
 public:
  std::string update(const TupleView& tuple) const override;
  void presence(const std::vector<OwnerId>& owners, bool absent) override;
  void set(OwnerId owner, std::string_view key, std::uint32_t number, bool introduce, std::string_view update) override;
  void gone(OwnerId owner, std::string_view key, std::uint32_t number, EventKind how) override;
  void snapshot(OwnerId owner) override;
  std::size_t size() const override { return text_.size(); }
  std::string finish() override;
  std::string lost(std::uint64_t events) override;

 private:
  void add(std::string_view event, std::string_view data);

  std::uint64_t events_ = 0;  ///< since the start: their ids
  std::string text_;
};

}  // namespace rubicon::web::api
