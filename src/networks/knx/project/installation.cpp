#include "networks/knx/project/installation.h"

#include <utility>

#include "networks/knx/groups/encoding.h"
#include "networks/knx/project/document.h"

namespace rubicon::networks::knx::project {

namespace {

/// Real objects state up to 24 types in 230 bytes.
constexpr std::size_t kMaxTypesText = 1024;

template <class T>
void fill(std::optional<T>& above, const std::optional<T>& below) {
  if (!above) above = below;
}

void fill(std::string& above, const std::string& below) {
  if (above.empty()) above = below;
}

}  // namespace

ObjectTraits traits_of(const xml::Attributes& attributes) {
  ObjectTraits traits;
  traits.communication = flag_of(attributes, "CommunicationFlag");
  traits.read = flag_of(attributes, "ReadFlag");
  traits.write = flag_of(attributes, "WriteFlag");
  traits.transmit = flag_of(attributes, "TransmitFlag");
  traits.types = groups::clean_text(attributes.text("DatapointType"), kMaxTypesText);
  traits.size = short_text(attributes, "ObjectSize");
  traits.text = short_text(attributes, "Text");
  traits.function_text = short_text(attributes, "FunctionText");
  traits.text_parameter = short_text(attributes, "TextParameterRefId");
  return traits;
}

ObjectTraits over(ObjectTraits above, const ObjectTraits& below) {
  fill(above.communication, below.communication);
  fill(above.read, below.read);
  fill(above.write, below.write);
  fill(above.transmit, below.transmit);
  fill(above.types, below.types);
  fill(above.size, below.size);
  fill(above.text_parameter, below.text_parameter);
  fill(above.text, below.text);
  fill(above.function_text, below.function_text);
  return above;
}

}  // namespace rubicon::networks::knx::project
