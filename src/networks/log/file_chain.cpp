#include "networks/log/file_chain.h"

#include <fmt/format.h>

#include "networks/log/csv_reader.h"
#include "networks/log/file_list.h"

namespace rubicon::networks::log {

namespace {

constexpr std::size_t kPiece = 64UL * 1024;
constexpr std::size_t kMaxTable = 16 * kPiece;

/// The second cell of the line whose first cell is `key`.
std::optional<std::string> label_in(const TextLine& line, const std::string& key) {
  std::vector<std::string_view> cells;
  split_cells(line.text, ",;\t", cells);
  if (cells.size() < 2 || cells[0] != key) return std::nullopt;
  return std::string(cells[1]);
}

}  // namespace

FileChain::FileChain(transport::Transports& transports, Recording& recording)
    : transports_(transports), recording_(recording), piece_(kPiece) {}

Result<void> FileChain::open(std::vector<std::string> files) {
  files_ = std::move(files);
  if (index_ >= files_.size()) index_ = 0;
  return open_current();
}

Result<void> FileChain::rewind() {
  index_ = 0;
  recording_.restart();
  return open_current();
}

Result<void> FileChain::open_current() {
  auto file = transports_.open_file(path());
  if (!file) return fail(file.error());
  std::vector<std::string> labels;
  for (const std::string& table : recording_.label_tables()) {
    auto label = label_of(table, number_in_name(path()));
    if (!label) return fail(label.error());
    labels.push_back(std::move(*label));
  }
  file_ = std::move(*file);
  ended_ = false;
  recording_.begin(path(), std::move(labels));
  return {};
}

Result<std::string> FileChain::label_of(const std::string& table, const std::string& key) {
  auto file = transports_.open_file(table);
  if (!file) return fail(file.error());
  LineReader lines;
  std::size_t read = 0;
  for (bool more = true; more && read < kMaxTable;) {
    const auto count = (*file)->read(piece_);
    if (!count) return fail(count.error());
    more = *count > 0;
    read += *count;
    if (more)
      lines.feed(ByteView(piece_).first(*count));
    else
      lines.end();
    while (const auto line = lines.next()) {
      if (auto label = label_in(*line, key)) return std::move(*label);
    }
  }
  return std::string();
}

Result<FileChain::Found> FileChain::next(Step& step) {
  if (auto found = recording_.next()) {
    step = std::move(*found);
    return Found::kStep;
  }
  if (auto failure = recording_.failure()) return fail(failure->code, fmt::format("{}: {}", path(), failure->text));
  if (recording_.has_more()) return Found::kNothingYet;
  if (!ended_) {
    const auto count = file_->read(piece_);
    if (!count) return fail(count.error());
    ended_ = *count == 0;
    if (ended_)
      recording_.end();
    else
      recording_.feed(ByteView(piece_).first(*count));
    return Found::kNothingYet;
  }
  if (index_ + 1 == files_.size()) return Found::kEnd;
  ++index_;
  if (auto opened = open_current(); !opened) return fail(opened.error());
  return Found::kNextFile;
}

}  // namespace rubicon::networks::log
