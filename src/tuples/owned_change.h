#pragma once

#include <string>

#include "tuples/change.h"

namespace rubicon::tuples {

/// A Change that owns its texts.
class OwnedChange {
 public:
  explicit OwnedChange(const Change& change) : change_(change) {
    if (const auto* set = std::get_if<TupleSet>(&change)) {
      key_ = set->tuple.key;
      value_ = set->tuple.value;
      media_type_ = set->tuple.media_type;
    } else if (const auto* gone = std::get_if<TupleGone>(&change)) {
      key_ = gone->key;
    }
  }

  /// Valid while this lives.
  Change view() const {
    auto change = change_;
    if (auto* set = std::get_if<TupleSet>(&change)) {
      set->tuple.key = key_;
      set->tuple.value = value_;
      set->tuple.media_type = media_type_;
    } else if (auto* gone = std::get_if<TupleGone>(&change)) {
      gone->key = key_;
    }
    return change;
  }

  /// Of a set or a deletion; else empty.
  const std::string& key() const { return key_; }

 private:
  Change change_;
  std::string key_, value_, media_type_;
};

}  // namespace rubicon::tuples
