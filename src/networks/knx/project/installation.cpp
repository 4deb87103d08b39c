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

void fill(std::string_view& above, std::string_view below) {
  if (above.empty()) above = below;
}

}  // namespace

bool ObjectTraits::flags_are_known() const {
  if (!communication.value_or(true)) return true;
  if (!communication || !write) return false;
  return *write || read.value_or(false) || transmit.value_or(false) || (read && transmit);
}

ObjectTraits traits_of(const xml::Attributes& attributes, KeptTexts& texts) {
  ObjectTraits traits;
  traits.communication = enabled(attributes, "CommunicationFlag");
  traits.read = enabled(attributes, "ReadFlag");
  traits.write = enabled(attributes, "WriteFlag");
  traits.transmit = enabled(attributes, "TransmitFlag");
  traits.types = texts.keep(groups::clean_text(attributes.text("DatapointType"), kMaxTypesText));
  traits.size = texts.keep(short_text(attributes, "ObjectSize"));
  traits.text = texts.keep(short_text(attributes, "Text"));
  traits.function_text = texts.keep(short_text(attributes, "FunctionText"));
  traits.text_parameter = texts.keep(short_text(attributes, "TextParameterRefId"));
  return traits;
}

ObjectTraits kept_in(KeptTexts& texts, ObjectTraits traits) {
  for (auto* text : {&traits.types, &traits.size, &traits.text, &traits.function_text, &traits.text_parameter})
    *text = texts.keep(*text);
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
