#include "networks/knx/project/module_ids.h"

#include <algorithm>

namespace rubicon::networks::knx::project {

namespace {

bool has_only(std::string_view text, std::string_view characters) {
  return !text.empty() && text.find_first_not_of(characters) == text.npos;
}

/// The part of an id up to the next `_`.
std::string_view part_of(std::string_view text) {
  return text.substr(0, text.find('_'));
}

/// The length of `M-20_MI-1_` at the beginning, and of `M-1_MI-1-1-2_` in a module of a module; 0 = it does not begin
/// so.
std::size_t instance_at(std::string_view text) {
  const auto module = part_of(text);
  if (module.size() == text.size()) return 0;
  const auto instance = part_of(text.substr(module.size() + 1));
  const auto end = module.size() + 1 + instance.size();
  const bool fits = module.starts_with("M-") && has_only(module.substr(2), "0123456789") &&
                    instance.starts_with("MI-") && has_only(instance.substr(3), "0123456789-") && end < text.size();
  return fits ? end + 1 : 0;
}

/// The instance of a module in a module repeats the definition before it: `SM-1_M-1_MI-1-1-2_SM-1_`.
std::size_t repeated_definition_at(std::string_view text, std::string_view written) {
  const auto definition = part_of(text);
  if (!definition.starts_with("SM-") || definition.size() == text.size()) return 0;
  const auto with_end = text.substr(0, definition.size() + 1);
  const auto before = written.size() - std::min(written.size(), with_end.size());
  const bool repeats = written.ends_with(with_end) && (before == 0 || written[before - 1] == '_');
  return repeats ? with_end.size() : 0;
}

}  // namespace

std::string without_module(std::string_view id, std::string& module) {
  std::string out;
  std::size_t at = 0, begin = id.npos;
  while (at < id.size()) {
    const bool part_begins = at == 0 || id[at - 1] == '_';
    if (part_begins && id.substr(at).starts_with("MD-")) begin = at;
    const auto skip = part_begins && begin != id.npos ? instance_at(id.substr(at)) : 0;
    if (skip == 0) {
      out += id[at++];
      continue;
    }
    at += skip;
    module = id.substr(begin, at - 1 - begin);
    at += repeated_definition_at(id.substr(at), out);
  }
  return out;
}

}  // namespace rubicon::networks::knx::project
