#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace rubicon::console {

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
/// Other sequences, control characters and broken UTF-8 are ignored. A sequence may come in pieces; at most kLongest
/// bytes of it are kept.
class StrokeReader {
 public:
  static constexpr std::size_t kLongest = 32;

  std::vector<Stroke> take(std::string_view bytes);
  /// Whether something was begun: ask settle() if no more comes soon.
  bool pending() const { return !held_.empty(); }
  /// Nothing more came: an escape on its own is the key of that name.
  std::vector<Stroke> settle();

 private:
  std::string held_;
};

}  // namespace rubicon::console
