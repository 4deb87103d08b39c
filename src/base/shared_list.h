#pragma once

#include <memory>
#include <utility>
#include <vector>

namespace rubicon::base {

/// A list whose items never change, so that copies share them.
template <class T>
class SharedList {
 public:
  SharedList() = default;
  SharedList(std::vector<T> items) {  // NOLINT(google-explicit-constructor): it is the same list
    items.shrink_to_fit();
    if (!items.empty()) items_ = std::make_shared<const std::vector<T>>(std::move(items));
  }

  const std::vector<T>& items() const {
    static const std::vector<T> kNone;
    return items_ ? *items_ : kNone;
  }
  operator const std::vector<T>&() const { return items(); }  // NOLINT(google-explicit-constructor)
  auto begin() const { return items().begin(); }
  auto end() const { return items().end(); }
  std::size_t size() const { return items().size(); }
  bool empty() const { return !items_; }
  const T& operator[](std::size_t index) const { return items()[index]; }
  const T& at(std::size_t index) const { return items().at(index); }
  /// Of those that share the items.
  long uses() const { return items_.use_count(); }

  friend bool operator==(const SharedList& one, const SharedList& other) {
    return one.items_ == other.items_ || one.items() == other.items();
  }

 private:
  std::shared_ptr<const std::vector<T>> items_;
};

}  // namespace rubicon::base
