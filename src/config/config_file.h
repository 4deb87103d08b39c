#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/config_reader.h"
#include "model/type_catalogue.h"
#include "rubicon/result.hpp"

namespace rubicon::config {

/// `networks.dummy-1.seed=7` or any other path (a part with dots in double quotes): replaces or creates the value, at
/// the place `--set ...`.
Result<void> apply_override(ConfigNode& root, std::string_view assignment);

/// File -> tree with the overrides applied; kNotFound, kIo or the errors of parse_yaml.
Result<ConfigNode> load_config(const std::string& path, const std::vector<std::string>& overrides);

/// `networks: [{type: wsn}, {type: knx}, {type: wsn}]` becomes a map of wsn-1, knx-1 and wsn-2: each is numbered by its
/// place among those of its type (D1.4, chapter 3: "By default this is a number automatically generated"). Anything
/// but a list is left alone. What has no type is called network-<place>, and refused by who reads it.
void number_networks(ConfigNode& root);

/// Declares the types of the section `types` of an island's configuration; errors are those of the reader.
void read_site_types(ConfigReader& root, TypeCatalogue& types);

}  // namespace rubicon::config
