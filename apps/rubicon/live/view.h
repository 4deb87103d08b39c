#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/rubicon/live/rows.h"

namespace rubicon::cli::live {

/// What the user typed.
struct Stroke {
  enum class Key {
    kText,  ///< one character, in `text`
    kEnter,
    kEscape,
    kTab,
    kBackspace,
    kEraseWord,  ///< Ctrl-W
    kEraseLine,  ///< Ctrl-U
    kRedraw,     ///< Ctrl-L
    kUp,
    kDown,
    kPageUp,
    kPageDown,
    kHome,
    kEnd,
    kEarlier,  ///< Ctrl-P
    kLater     ///< Ctrl-N
  };
  Key key = Key::kText;
  std::string text{};

  friend bool operator==(const Stroke&, const Stroke&) = default;
};

/// Bytes of a terminal in raw mode -> strokes. Knows the sequences of VT220, xterm, rxvt, tmux and the Linux console
/// (xterm: ctlseqs.ms, "PC-Style Function Keys", "VT220-Style Function Keys"), with modifiers, which do not count.
/// Other sequences, control characters and broken UTF-8 are ignored. A sequence may come in pieces; at most kMaxLength
/// bytes of it are kept.
class StrokeReader {
 public:
  static constexpr std::size_t kMaxLength = 32;

  std::vector<Stroke> take(std::string_view bytes);
  /// Whether something was begun: ask settle() if no more comes soon.
  bool pending() const { return !held_.empty(); }
  /// Nothing more came: an escape on its own is the key of that name.
  std::vector<Stroke> settle();

 private:
  std::string held_;
};

/// What the user sees of the live table and types into it; a pure function of the strokes. Letters begin a command
/// line; all that moves, sorts and folds is on other keys (LiveView::help()).
class LiveView {
 public:
  /// The line that ends the table; its first letter alone does so too.
  static constexpr std::string_view kQuit = "quit";
  /// Of a line that is typed, in bytes.
  static constexpr std::size_t kMaxLine = 4096;
  enum class Log : std::uint8_t { kHidden, kBelow, kWhole };
  enum class Prompt : std::uint8_t { kNone, kCommand, kFilter };
  /// What the strokes act on.
  struct Scene {
    const std::vector<LiveRow>& rows;
    std::size_t height = 1;       ///< rows of the table on the screen
    std::size_t log_lines = 0;    ///< that there are
    std::string proposal{};       ///< what Tab types
    std::string selected_name{};  ///< of the selected row on the command line, if it is a point
  };

  /// A command line that was entered, if one was.
  std::optional<std::string> press(const Stroke& stroke, const Scene& scene);
  /// The rows changed: stays at the same one, or near it, and inside.
  void follow(const Scene& scene);

  const LiveChoice& choice() const { return choice_; }
  std::size_t selected() const { return selected_; }
  std::size_t top() const { return top_; }  ///< first row of the table on the screen
  Log log() const { return log_; }
  std::size_t log_back() const { return log_back_; }  ///< lines between the last one on the screen and the newest
  bool help_shown() const { return help_; }
  Prompt prompt() const { return prompt_; }
  const std::string& typed() const { return typed_; }

  static const std::vector<std::string>& help();

 private:
  static constexpr std::size_t kMaxEarlier = 100;

  std::optional<std::string> enter(const Scene& scene);
  void type(const std::string& text);
  void escape();
  void erase(Stroke::Key key);
  void move(Stroke::Key key, const Scene& scene);
  void move_log(Stroke::Key key, const Scene& scene);
  void look(char key, const Scene& scene);
  void sort(int step);
  void open_or_fold(const Scene& scene);
  void fold_all(bool fold, const Scene& scene);
  void recall(int step);

  LiveChoice choice_;
  std::string selected_key_;
  std::size_t selected_ = 0, top_ = 0, log_back_ = 0;
  Log log_ = Log::kHidden;
  bool help_ = false;
  Prompt prompt_ = Prompt::kNone;
  std::string typed_;
  std::deque<std::string> earlier_;  ///< commands, the newest last
  std::size_t recalled_ = 0;         ///< how many back; 0 = none
};

}  // namespace rubicon::cli::live
