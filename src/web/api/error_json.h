#pragma once

#include <nlohmann/json.hpp>

#include "rubicon/result.hpp"

namespace rubicon::web::api {

/// {"code","text"}
inline nlohmann::ordered_json error_json(const Error& error) {
  nlohmann::ordered_json tree;
  tree["code"] = to_string(error.code);
  tree["text"] = error.text;
  return tree;
}

}  // namespace rubicon::web::api
