#include "apps/rubicon-proxy/recording_tool.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <set>
#include <unordered_set>

#include "apps/rubicon-proxy/daemon.h"
#include "base/own_file.h"
#include "base/text.h"
#include "model/point_keys.h"
#include "recording/record.h"
#include "recording/recording_reader.h"
#include "transport/local_transports.h"

namespace rubicon::daemon {

namespace {

using recording::Record;
using recording::RecordingReader;
using recording::RecordKind;

constexpr std::size_t kMaxMarksShown = 100;
constexpr std::size_t kMaxDamageShown = 20;
constexpr std::size_t kMaxKeysCounted = 5'000'000;

/// Visits all that is in a file; kInvalid if there is nothing in it that a recording has.
Result<void> walk(transport::Transports& transports, const std::string& path, const recording::VisitItem& visit) {
  const auto file = transports.open_file(path);
  if (!file) return fail(file.error());
  bool sound = false;
  std::vector<recording::Damage> before;  // damage at the beginning: the file may be no recording
  const auto take = [&](const RecordingReader::Item& item) -> Result<void> {
    const auto* damage = std::get_if<recording::Damage>(&item);
    if (damage != nullptr && !sound) {
      before.push_back(*damage);
      return {};
    }
    sound = true;
    for (const auto& one : std::exchange(before, {})) {
      if (auto visited = visit(one); !visited) return visited;
    }
    return visit(item);
  };
  auto done = recording::each_item([&](std::span<std::uint8_t> into) { return (*file)->read(into); }, take);
  if (done && !sound) return fail(ErrorCode::kInvalid, path + ": is not a recording");
  return done;
}

/// What `info` tells.
struct Summary {
  std::optional<recording::FileHead> head;
  std::array<std::uint64_t, 5> by_kind{};
  std::uint64_t blocks = 0, packed = 0, raw = 0, damaged = 0, lost = 0;
  std::optional<WallTime> first, last;
  std::unordered_set<std::string> keys;
  std::set<std::string> networks;
  std::uint64_t marked = 0;
  std::vector<std::string> marks, damage;

  void take(const recording::BlockFound& block) {
    ++blocks;
    packed += recording::kBlockHead + block.head.packed;
    raw += block.head.raw;
    if (!first) first = block.head.first;
    last = block.head.last;
  }
  void take(const Record& record) {
    ++by_kind[static_cast<std::size_t>(record.kind)];
    if (record.kind == RecordKind::kMark) return take_mark(record);
    if (keys.size() >= kMaxKeysCounted) return;
    if (!keys.insert(fmt::format("{}:{}", number(record.owner), record.key)).second) return;
    const auto parts = model::key_parts(record.key);
    const bool of_network = parts.size() == 3 && parts[2] == "status";
    const bool of_point = parts.size() == 6 && parts[5] == "value";
    if (!head || !(of_network || of_point) || parts[0] != head->prefix || model::is_of_island(record.key)) return;
    if (parts[1] == model::to_key_part(parts[1])) networks.emplace(parts[1]);
  }
  void take_mark(const Record& record) {
    if (!record.value.starts_with(recording::kMarkOfUser)) return;
    ++marked;
    const auto text = base::one_line(record.value.substr(recording::kMarkOfUser.size()));
    if (marks.size() < kMaxMarksShown) marks.push_back(fmt::format("  {}{}\n", recording::utc_text(record.seen), text));
  }
  void take(const recording::Damage& one) {
    ++damaged;
    lost += one.bytes;
    if (damage.size() < kMaxDamageShown)
      damage.push_back(fmt::format("  byte {}: {}; {} bytes skipped\n", one.offset, one.why, one.bytes));
  }
  void take(const recording::FileHead& one) { head = one; }
};

std::string text_of(const Summary& sum, const std::string& file) {
  std::string out = fmt::format("file: {}\n", file);
  if (sum.head) {
    out += fmt::format("island: {}, prefix {}\n", number(sum.head->island), model::quoted(sum.head->prefix));
    out += fmt::format("written by: {}\n", model::quoted(sum.head->writer));
  } else {
    out += "island: the head is damaged\n";
  }
  out += fmt::format("first record: {}\n", sum.first ? recording::utc_text(*sum.first) : "none");
  out += fmt::format("last record: {}\n", sum.last ? recording::utc_text(*sum.last) : "none");
  out += fmt::format("blocks: {} ({} bytes, {} uncompressed)\n", sum.blocks, sum.packed, sum.raw);
  std::uint64_t records = 0;
  for (std::size_t kind = 0; kind + 1 < sum.by_kind.size(); ++kind) records += sum.by_kind[kind];
  out += fmt::format("records: {} ({} set, {} deleted, {} expired, {} present in snapshots)\n", records, sum.by_kind[0],
                     sum.by_kind[1], sum.by_kind[2], sum.by_kind[3]);
  out += fmt::format("keys: {}\n", sum.keys.size());
  out +=
      fmt::format("networks: {}\n", sum.networks.empty() ? "none" : fmt::format("{}", fmt::join(sum.networks, ", ")));
  if (sum.marked > 0) out += fmt::format("marks: {}\n", sum.marked);
  for (const auto& line : sum.marks) out += line;
  if (sum.damaged == 0) return out + "damage: none\n";
  out += fmt::format("damage: {} places, {} bytes\n", sum.damaged, sum.lost);
  for (const auto& line : sum.damage) out += line;
  return out;
}

/// The file that is exported to, or standard output.
class Output {
 public:
  Output() = default;
  ~Output() {
    if (file_ != nullptr && file_ != stdout) std::fclose(file_);
  }
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  Result<void> open(const std::string& path) {
    path_ = path.empty() ? "standard output" : path;
    if (path.empty()) {
      file_ = stdout;
      return {};
    }
    auto target = OwnFile::open(path, O_WRONLY | O_EXCL);
    if (!target) return fail(ErrorCode::kIo, std::move(target.error().text));
    file_ = ::fdopen(target->release(), "w");
    return file_ != nullptr ? Result<void>() : refused("create");
  }
  Result<void> write(std::string_view text) {
    return std::fwrite(text.data(), 1, text.size(), file_) == text.size() ? Result<void>() : refused("write");
  }
  Result<void> finish() { return std::fflush(file_) == 0 ? Result<void>() : refused("write"); }

 private:
  Result<void> refused(std::string_view doing) {
    return fail(ErrorCode::kIo, fmt::format("{}: cannot {}: {}", path_, doing, std::strerror(errno)));
  }
  std::FILE* file_ = nullptr;
  std::string path_;
};

int ended(const Result<void>& done) {
  if (done) return kExitOk;
  fmt::print(stderr, "{}\n", done.error().text);
  return done.error().code == ErrorCode::kIo ? kExitFailed : kExitConfiguration;
}

}  // namespace

Result<void> describe_recording(transport::Transports& transports, const std::string& file, const WriteText& write) {
  Summary sum;
  auto walked = walk(transports, file, [&sum](const RecordingReader::Item& item) -> Result<void> {
    std::visit([&sum](const auto& one) { sum.take(one); }, item);
    return {};
  });
  if (!walked) return walked;
  return write(text_of(sum, file));
}

Result<void> export_recording(transport::Transports& transports, const RecordingOptions& options,
                              const WriteText& write, const std::function<void(std::string_view)>& damaged) {
  std::optional<Pattern> pattern;
  if (!options.pattern.empty()) {
    auto parsed = Pattern::parse(options.pattern);
    if (!parsed) return fail(ErrorCode::kInvalid, "--pattern: " + parsed.error().text);
    pattern = *parsed;
  }
  std::string line;
  bool begun = options.jsonl;
  auto walked = walk(transports, options.file, [&](const RecordingReader::Item& item) -> Result<void> {
    if (const auto* damage = std::get_if<recording::Damage>(&item))
      damaged(
          fmt::format("{}: byte {}: {}; {} bytes skipped", options.file, damage->offset, damage->why, damage->bytes));
    const auto* record = std::get_if<Record>(&item);
    if (record == nullptr || record->kind == RecordKind::kMark) return {};
    if (pattern && !pattern->matches(record->owner, record->key)) return {};
    line.clear();
    if (!std::exchange(begun, true)) line = recording::kCsvHeader;
    options.jsonl ? recording::append_json_line(*record, line) : recording::append_csv_line(*record, line);
    return write(line);
  });
  if (walked && !begun) return write(recording::kCsvHeader);
  return walked;
}

int recording(const RecordingOptions& options) {
  transport::LocalTransports transports;
  Output output;
  if (auto opened = output.open(options.action == "info" ? "" : options.out); !opened) return ended(opened);
  const WriteText write = [&output](std::string_view text) { return output.write(text); };
  auto done = options.action == "info" ? describe_recording(transports, options.file, write)
                                       : export_recording(transports, options, write, [](std::string_view text) {
                                           fmt::print(stderr, "{}\n", text);
                                         });
  if (done) done = output.finish();
  return ended(done);
}

}  // namespace rubicon::daemon
