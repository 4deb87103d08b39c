#include "apps/rubicon/live/view.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "base/text.h"

namespace rubicon::cli::live {

namespace {

using Key = Stroke::Key;

constexpr char kEscape = '\x1b';

std::optional<Key> control_key(char c) {
  switch (c) {
    case '\r':
    case '\n': return Key::kEnter;
    case '\t': return Key::kTab;
    case '\b':
    case '\x7f': return Key::kBackspace;
    case '\x0c': return Key::kRedraw;
    case '\x0e': return Key::kLater;
    case '\x10': return Key::kEarlier;
    case '\x15': return Key::kEraseLine;
    case '\x17': return Key::kEraseWord;
    default: return std::nullopt;
  }
}

/// Of `ESC [ 5 ~` the number, of `ESC [ A` and `ESC O A` the letter.
std::optional<Key> sequence_key(std::string_view sequence) {
  constexpr std::array<std::pair<char, Key>, 4> kLetters{
      {{'A', Key::kUp}, {'B', Key::kDown}, {'H', Key::kHome}, {'F', Key::kEnd}}};
  constexpr std::array<std::pair<std::string_view, Key>, 6> kNumbers{{{"1", Key::kHome},
                                                                      {"7", Key::kHome},
                                                                      {"4", Key::kEnd},
                                                                      {"8", Key::kEnd},
                                                                      {"5", Key::kPageUp},
                                                                      {"6", Key::kPageDown}}};
  const auto last = sequence.back();
  for (const auto& [letter, key] : kLetters) {
    if (letter == last) return key;
  }
  if (last != '~') return std::nullopt;
  const auto number = sequence.substr(2, sequence.find_first_of(";~", 2) - 2);
  for (const auto& [digits, key] : kNumbers) {
    if (digits == number) return key;
  }
  return std::nullopt;
}

/// Bytes of the sequence that begins here (ECMA-48, 5.4); 0 = its end has not come yet.
std::size_t sequence_length(std::string_view bytes) {
  if (bytes.size() < 2) return 0;
  if (bytes[1] == 'O') return bytes.size() < 3 ? 0 : 3;
  if (bytes[1] != '[') return 1;  // an escape, then another key
  for (std::size_t i = 2; i < bytes.size(); ++i) {
    if (bytes[i] >= 0x40 && bytes[i] <= 0x7e) return i + 1;
    if (bytes[i] < 0x20 || bytes[i] > 0x3f) return i;  // broken off
  }
  return 0;
}

bool continues(char c) {
  return (static_cast<unsigned char>(c) & 0xc0U) == 0x80;
}

/// Bytes of the UTF-8 character that begins here, 1 for what begins none; 0 = its end has not come yet.
std::size_t character_length(std::string_view bytes) {
  const auto first = static_cast<unsigned char>(bytes.front());
  if (first < 0xc2 || first > 0xf4) return 1;
  const std::size_t length = first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  for (std::size_t i = 1; i < length; ++i) {
    if (i == bytes.size()) return 0;
    if (!continues(bytes[i])) return 1;  // broken off
  }
  return length;
}

/// Takes one stroke, or bytes that are not a stroke, from the front. False: more bytes are needed.
bool take_one(std::string_view& bytes, std::vector<Stroke>& strokes) {
  std::size_t length = 1;
  if (bytes.front() == kEscape) {
    length = sequence_length(bytes);
    if (length == 0) return false;
    const auto key = length == 1 ? std::optional(Key::kEscape) : sequence_key(bytes.substr(0, length));
    if (key) strokes.push_back({*key});
  } else if (const auto key = control_key(bytes.front())) {
    strokes.push_back({*key});
  } else if (static_cast<unsigned char>(bytes.front()) >= 0x20) {
    length = character_length(bytes);
    if (length == 0) return false;
    const auto character = bytes.substr(0, length);
    if (base::is_utf8(character)) {
      strokes.push_back({Key::kText, std::string(character)});
    } else {
      length = 1;
    }
  }
  bytes.remove_prefix(length);
  return true;
}

}  // namespace

std::vector<Stroke> StrokeReader::take(std::string_view bytes) {
  const auto all = std::exchange(held_, {}) + std::string(bytes);
  std::vector<Stroke> strokes;
  auto rest = std::string_view(all);
  while (!rest.empty() && take_one(rest, strokes)) continue;
  if (rest.size() < kMaxLength) held_ = rest;
  return strokes;
}

std::vector<Stroke> StrokeReader::settle() {
  const bool escape = std::exchange(held_, {}) == std::string(1, kEscape);
  return escape ? std::vector<Stroke>{{Key::kEscape}} : std::vector<Stroke>{};
}

namespace {

/// Removes the last character, which may be of several bytes.
void erase_character(std::string& text) {
  while (!text.empty()) {
    const auto last = static_cast<unsigned char>(text.back());
    text.pop_back();
    if ((last & 0xc0U) != 0x80) return;
  }
}

void erase_word(std::string& text) {
  while (!text.empty() && text.back() == ' ') text.pop_back();
  while (!text.empty() && text.back() != ' ') text.pop_back();
}

std::size_t moved(std::size_t at, Key key, std::size_t page, std::size_t count) {
  switch (key) {
    case Key::kUp: return at - std::min<std::size_t>(at, 1);
    case Key::kDown: return at + 1;
    case Key::kPageUp: return at - std::min(at, page);
    case Key::kPageDown: return at + page;
    case Key::kHome: return 0;
    default: return count;
  }
}

}  // namespace

const std::vector<std::string>& LiveView::help() {
  static const std::vector<std::string> lines{
      "The live table",
      "  Up, Down, PgUp, PgDn, Home, End   move",
      "  /                                 filter: words that must all stand in",
      "                                    a row or above it (kitchen stale)",
      "  < >                               sort: network name latest busiest trouble",
      "  Enter                             fold, unfold; on an actuator, begin to set",
      "  - +                               fold and unfold all",
      "  !                                 the log: below the table, alone, hidden",
      "  ? Esc                             this page; leaves a line, page, filter",
      "  q, Ctrl-C                         ends the table, not the islands",
      "Every other letter begins a command line of rubicon, and so does a colon:",
      "  set living.lamp-1 on, get, describe, devices, inbox, alerts, ...",
      "  Tab; Ctrl-P, Ctrl-N               the proposed line; earlier, later ones",
      "  Ctrl-W, Ctrl-U                    erase a word, the line",
      "While the table is shown all sensors are sampled (top --passive: none).",
  };
  return lines;
}

std::optional<std::string> LiveView::press(const Stroke& stroke, const Scene& scene) {
  switch (stroke.key) {
    case Key::kText:
      if (prompt_ == Prompt::kNone && stroke.text.size() == 1 &&
          std::string_view("/<>-+!?:").find(stroke.text[0]) != std::string_view::npos) {
        look(stroke.text[0], scene);
      } else if (prompt_ == Prompt::kNone && stroke.text == kQuit.substr(0, 1)) {
        return std::string(kQuit);
      } else {
        type(stroke.text);
      }
      break;
    case Key::kEnter: return enter(scene);
    case Key::kEscape: escape(); break;
    case Key::kTab:
      if (prompt_ == Prompt::kNone) type(scene.proposal);
      break;
    case Key::kBackspace:
    case Key::kEraseWord:
    case Key::kEraseLine: erase(stroke.key); break;
    case Key::kEarlier: recall(1); break;
    case Key::kLater: recall(-1); break;
    case Key::kRedraw: break;
    default: move(stroke.key, scene); break;
  }
  return std::nullopt;
}

void LiveView::type(const std::string& text) {
  if (prompt_ == Prompt::kNone && text == " ") return;
  if (prompt_ == Prompt::kNone) prompt_ = Prompt::kCommand;
  if (typed_.size() + text.size() <= kMaxLine) typed_ += text;
  if (prompt_ == Prompt::kFilter) choice_.filter = typed_;
}

std::optional<std::string> LiveView::enter(const Scene& scene) {
  const auto prompt = std::exchange(prompt_, Prompt::kNone);
  auto line = std::exchange(typed_, {});
  recalled_ = 0;
  if (prompt == Prompt::kFilter) return std::nullopt;
  if (prompt == Prompt::kNone) {
    if (help_ || log_ == Log::kWhole) return std::nullopt;
    open_or_fold(scene);
    return std::nullopt;
  }
  if (line.find_first_not_of(' ') == line.npos) return std::nullopt;
  if (earlier_.empty() || earlier_.back() != line) earlier_.push_back(line);
  if (earlier_.size() > kMaxEarlier) earlier_.pop_front();
  return line;
}

void LiveView::escape() {
  if (prompt_ != Prompt::kNone) {
    if (prompt_ == Prompt::kFilter) choice_.filter.clear();
    prompt_ = Prompt::kNone;
    typed_.clear();
    recalled_ = 0;
  } else if (help_) {
    help_ = false;
  } else if (log_ != Log::kHidden) {
    log_ = Log::kHidden;
  } else {
    choice_.filter.clear();
  }
}

void LiveView::erase(Key key) {
  if (prompt_ == Prompt::kNone) return;
  if (typed_.empty() && key == Key::kBackspace) return escape();
  if (key == Key::kBackspace) erase_character(typed_);
  if (key == Key::kEraseWord) erase_word(typed_);
  if (key == Key::kEraseLine) typed_.clear();
  if (prompt_ == Prompt::kFilter) choice_.filter = typed_;
}

void LiveView::look(char key, const Scene& scene) {
  switch (key) {
    case '/':
      prompt_ = Prompt::kFilter;
      typed_ = choice_.filter;
      help_ = false;
      break;
    case ':': prompt_ = Prompt::kCommand; break;
    case '<': sort(-1); break;
    case '>': sort(1); break;
    case '-': fold_all(true, scene); break;
    case '+': fold_all(false, scene); break;
    case '!':
      log_ = log_ == Log::kHidden ? Log::kBelow : log_ == Log::kBelow ? Log::kWhole : Log::kHidden;
      log_back_ = 0;
      break;
    default: help_ = !help_; break;
  }
}

void LiveView::sort(int step) {
  choice_.sort = static_cast<LiveSort>((static_cast<int>(choice_.sort) + kLiveSorts + step) % kLiveSorts);
}

void LiveView::open_or_fold(const Scene& scene) {
  if (selected_ >= scene.rows.size()) return;
  const auto& row = scene.rows[selected_];
  if (row.kind != LiveRow::Kind::kPoint) {
    if (choice_.folded.erase(row.key) == 0) choice_.folded.insert(row.key);
  } else if (row.key.find(".actuator.") != row.key.npos) {
    type("set " + scene.selected_name + " ");
  }
}

void LiveView::fold_all(bool fold, const Scene& scene) {
  choice_.folded.clear();
  const auto kind = choice_.sort == LiveSort::kNetwork ? LiveRow::Kind::kNetwork : LiveRow::Kind::kDevice;
  for (const auto& row : scene.rows) {
    if (fold && row.kind == kind) choice_.folded.insert(row.key);
  }
}

void LiveView::recall(int step) {
  if (prompt_ == Prompt::kFilter) return;
  const auto most = static_cast<int>(earlier_.size());
  recalled_ = static_cast<std::size_t>(std::clamp(static_cast<int>(recalled_) + step, 0, most));
  typed_ = recalled_ == 0 ? std::string() : earlier_[earlier_.size() - recalled_];
  prompt_ = typed_.empty() ? Prompt::kNone : Prompt::kCommand;
}

void LiveView::move(Key key, const Scene& scene) {
  if (log_ == Log::kWhole) return move_log(key, scene);
  selected_ = moved(selected_, key, std::max<std::size_t>(scene.height, 1), scene.rows.size());
  selected_ = std::min(selected_, scene.rows.empty() ? 0 : scene.rows.size() - 1);
  selected_key_ = selected_ < scene.rows.size() ? scene.rows[selected_].key : std::string();
  if (selected_ == 0) selected_key_.clear();  // at the top one stays at the top
  follow(scene);
}

void LiveView::move_log(Key key, const Scene& scene) {
  const auto most = scene.log_lines - std::min(scene.log_lines, scene.height);
  const auto top = most - std::min(most, log_back_);
  log_back_ = most - std::min(moved(top, key, std::max<std::size_t>(scene.height, 1), most), most);
}

void LiveView::follow(const Scene& scene) {
  const auto& rows = scene.rows;
  if (!selected_key_.empty()) {
    const auto found =
        std::find_if(rows.begin(), rows.end(), [this](const LiveRow& row) { return row.key == selected_key_; });
    if (found != rows.end()) selected_ = static_cast<std::size_t>(found - rows.begin());
  }
  selected_ = std::min(selected_, rows.empty() ? 0 : rows.size() - 1);
  const auto height = std::max<std::size_t>(scene.height, 1);
  top_ = std::min(top_, rows.size() - std::min(rows.size(), height));
  top_ = std::min(top_, selected_);
  if (selected_ >= top_ + height) top_ = selected_ - height + 1;
}

}  // namespace rubicon::cli::live
