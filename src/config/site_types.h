#pragma once

#include "base/config_reader.h"
#include "model/type_catalogue.h"

namespace rubicon::config {

/// Declares the types of the section `types` of an island's configuration; errors are those of the reader.
void read_site_types(ConfigReader& root, TypeCatalogue& types);

}  // namespace rubicon::config
