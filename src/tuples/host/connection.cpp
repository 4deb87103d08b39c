#include "tuples/host/connection.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "tuples/distant/frame_codec.h"

namespace rubicon::tuples::host {

namespace {

constexpr std::size_t kTokenDigits = 16;

}  // namespace

void append(Bytes& out, const Record& record) {
  const auto begin = out.size();
  distant::FieldWriter fields;
  fields.byte(static_cast<std::uint8_t>(record.type));
  fields.number(number(record.id));
  fields.number(number(record.target));
  fields.number(record.number);
  fields.text(record.text);
  const auto head = fields.view();
  out.resize(begin + kSizeBytes);
  out.insert(out.end(), head.begin(), head.end());
  out.insert(out.end(), record.content.begin(), record.content.end());
  put_size(std::span(out).subspan(begin));
}

void put_size(std::span<std::uint8_t> record) {
  const auto size = record.size() - kSizeBytes;
  for (std::size_t at = 0; at < kSizeBytes; ++at) record[at] = static_cast<std::uint8_t>(size >> (8 * at) & 0xff);
}

Result<Record> read_record(ByteView bytes) {
  distant::FieldReader in(bytes);
  Record record;
  const auto type = in.byte();
  record.type = static_cast<Record::Type>(type);
  record.id = in.owner();
  record.target = in.owner();
  record.number = in.number();
  record.text = in.text();
  record.content = in.rest();
  const bool known = type >= static_cast<std::uint8_t>(Record::Type::kHello) &&
                     type <= static_cast<std::uint8_t>(Record::Type::kGoodbye);
  if (in.ok() && known && record.text.size() <= Record::kMaxText) return record;
  return fail(ErrorCode::kInvalid, fmt::format("invalid record of type {}", type));
}

bool is_token(std::string_view text) {
  return text.size() == kTokenDigits &&
         std::all_of(text.begin(), text.end(), [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

namespace {

std::size_t size_at(ByteView bytes) {
  std::size_t size = 0;
  for (std::size_t at = 0; at < kSizeBytes; ++at) size |= std::size_t{bytes[at]} << (8 * at);
  return size;
}

}  // namespace

transport::LocalCallbacks Connection::begin(Callbacks calls) {
  callbacks_ = std::move(calls);
  return {lifetime_.guard([this](ByteView bytes) { received(bytes); }), lifetime_.guard([this] { flush(); }),
          lifetime_.guard([this](const Error& why) { end(why); })};
}

void Connection::take(std::unique_ptr<transport::LocalStream> stream) {
  stream_ = std::move(stream);
  if (waiting() > 0) flush_soon_.request();
}

void Connection::loop(Callbacks calls) {
  std::ignore = begin(std::move(calls));
  loops_ = true;
}

void Connection::send(const Record& record) {
  if (closed_) return;
  if (waiting() > kMaxWaiting)
    return lifetime_.post(scheduler_, [this] { end({ErrorCode::kBusy, "the other process reads nothing"}); });
  if (!lengthen_last(record)) {
    last_ = {record.type, record.id, record.target, record.number};
    last_at_ = out_.size();
    append(out_, record);
  }
  flush_soon_.request();
}

/// Adds the entries of a frame to the frame before it, if both have one way.
bool Connection::lengthen_last(const Record& record) {
  const auto& [type, id, target, number, text, content] = record;
  const bool same = !out_.empty() && type == Record::Type::kFrame && last_.type == type && last_.id == id &&
                    last_.target == target && last_.number == number;
  if (!same || out_.size() - last_at_ + content.size() > kFrameBytes) return false;
  out_.insert(out_.end(), content.begin(), content.end());
  put_size(std::span(out_).subspan(last_at_));
  return true;
}

void Connection::watch_reading() {
  has_read_ = false;
  if (stream_) unread_ = stream_->unread();
}

bool Connection::has_read() {
  look_at_unread();
  return std::exchange(has_read_, false);
}

/// What the system holds becomes less only when the other process reads. How much it holds for a byte is its own
/// matter.
void Connection::look_at_unread() {
  if (!unread_ || !stream_) return;
  const auto now = stream_->unread();
  has_read_ |= now < *unread_;
  unread_ = now;
}

Result<std::size_t> Connection::write(ByteView bytes) {
  look_at_unread();
  const auto done = stream_->write(bytes);
  if (unread_) unread_ = stream_->unread();
  return done;
}

void Connection::flush() {
  if (loops_) {
    const auto bytes = std::exchange(out_, {});
    return received(bytes);
  }
  if (!stream_ || closed_) return;
  const ByteView fresh(out_);
  if (queue_.empty() && !fresh.empty()) {
    const auto done = write(fresh);
    if (done) {  // else `failed` follows
      const auto rest = fresh.subspan(*done);
      queue_.assign(rest.begin(), rest.end());
    }
    return base::drop_front(out_, out_.size());
  }
  queue_.insert(queue_.end(), fresh.begin(), fresh.end());
  base::drop_front(out_, out_.size());
  if (queue_.empty()) return;
  const auto done = write(ByteView(queue_).subspan(written_));
  written_ += done ? *done : queue_.size() - written_;
  if (written_ < queue_.size() && written_ < queue_.size() / 2) return;
  base::drop_front(queue_, std::exchange(written_, 0));
}

void Connection::release() {
  held_ = false;
  received({});
}

void Connection::received(ByteView bytes) {
  if (closed_) return;
  if (held_ && partial_.size() + bytes.size() > kMaxHeld)
    return end({ErrorCode::kInvalid, fmt::format("more than {} bytes before its user is known", kMaxHeld)});
  const auto alive = lifetime_.watch();
  auto whole = std::exchange(partial_, {});
  const bool continues = !whole.empty();
  if (continues) {
    whole.insert(whole.end(), bytes.begin(), bytes.end());
    bytes = whole;
  }
  const auto done = pass_records(bytes);
  if (alive.ended() || closed_) return;
  if (continues)
    base::drop_front(whole, done);
  else
    whole.assign(bytes.begin() + static_cast<std::ptrdiff_t>(done), bytes.end());
  partial_ = std::move(whole);
  // Answers go at once, so that the other process works on them while this one reads on.
  if (!loops_ && !out_.empty() && queue_.empty()) flush();
}

/// Returns the size of the records that were passed. A call may close or destroy this.
std::size_t Connection::pass_records(ByteView bytes) {
  const auto alive = lifetime_.watch();
  std::size_t at = 0;
  while (!held_ && bytes.size() - at >= kSizeBytes) {
    const auto size = size_at(bytes.subspan(at));
    if (size > kMaxRecord) {
      end({ErrorCode::kInvalid, fmt::format("a record of {} bytes, expected at most {}", size, kMaxRecord)});
      return at;
    }
    if (bytes.size() - at - kSizeBytes < size) break;
    const auto record = read_record(bytes.subspan(at + kSizeBytes, size));
    at += kSizeBytes + size;
    if (record) callbacks_.record(*record);
    if (!record) end(record.error());
    if (alive.ended() || closed_) return at;
  }
  return at;
}

void Connection::end(const Error& why) {
  if (closed_) return;
  close();
  const auto call = callbacks_.ended;  // may destroy this
  call(why);
}

void Connection::close() {
  closed_ = true;
  stream_.reset();
  queue_.clear();
  written_ = 0;
  out_.clear();
}

}  // namespace rubicon::tuples::host
