#include <cstdlib>

#include "apps/simulators/salad/script.h"
#include "fuzz_target.h"
#include "networks/salad/properties_reader.h"
#include "networks/salad/salad_options.h"
#include "support/memory/memory_transports.h"

namespace rubicon::fuzz::salad_properties_fuzz {

/// A properties file, read to the end; the same text as a simulator's script.
FUZZ_TARGET(salad_properties) {
  using namespace rubicon;
  using namespace rubicon::networks::salad;
  static const TypeCatalogue types;
  const auto text = base::as_text(ByteView(data, size));
  int line = 0;
  for (const auto& property : read_properties(text)) {
    if (property.line <= line) std::abort();
    line = property.line;
  }
  transport::MemoryTransports files;
  files.put("f", text);
  ConfigNode name, options;
  name.kind = ConfigNode::Kind::kScalar;
  name.text = "f";
  options.kind = ConfigNode::Kind::kMap;
  options.entries.emplace_back("properties", name);
  ConfigErrors errors;
  ConfigReader reader(options, "", errors);
  const auto read = read_salad_options({"salad", IslandId{1}, reader, types, {}}, files);
  for (const auto& [id, device] : read.devices) {
    if (id == 0 || types.find(device.type_id) == nullptr || device.name.empty()) std::abort();
    if (device.actuator.find_first_of(":#;") != std::string::npos) std::abort();
  }
  if (read.devices.empty() && errors.empty()) std::abort();
  if (const auto steps = salad_simulator::parse_script(text); !steps && steps.error().text.empty()) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::salad_properties_fuzz
