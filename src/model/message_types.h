#pragma once

#include <string_view>

namespace rubicon::model {

/// Whether messages of this content type (Opaque::type) change an installation, as `zigbee.admin` does, and so need an
/// administrator: its name ends with `.admin`. The name shows it, because a program that checks rights does not have
/// the networks of other islands.
constexpr bool is_admin_type(std::string_view type) {
  return type.ends_with(".admin");
}

}  // namespace rubicon::model
