#include "networks/knx/dpt/convert_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "model/json_text.h"
#include "networks/knx/dpt/codec.h"

namespace rubicon::networks::knx::dpt {

namespace {

/// The type at the start of a line, and the rest of the line.
struct Line {
  const Dpt* type = nullptr;
  std::string_view rest;
};

bool is_blank(char c) {
  return c == ' ' || c == '\t';
}

Result<Line> split(std::string_view line) {
  while (!line.empty() && (line.back() == '\r' || line.back() == '\n')) line.remove_suffix(1);
  while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
  const auto end = static_cast<std::size_t>(std::ranges::find_if(line, is_blank) - line.begin());
  const auto id = parse_dpt(line.substr(0, end));
  if (!id) return fail(id.error());
  const auto* type = find_dpt(*id);
  if (!type) return fail(ErrorCode::kNotFound, fmt::format("data point type {} is not known", to_string(*id)));
  return Line{type, line.substr(std::min(end + 1, line.size()))};
}

bool has_own_text(const Dpt& type) {
  return type.form == Form::kCharacter || type.form == Form::kText || type.form == Form::kLongText;
}

std::string error_line(const Error& error) {
  return "error: " + error.text;
}

/// Quoted if the text would not survive in a line unchanged.
std::string text_line(const std::string& text) {
  const auto control = [](char c) { return static_cast<unsigned char>(c) < 0x20; };
  const bool plain = !text.empty() && text.front() != '"' && !is_blank(text.front()) && !is_blank(text.back()) &&
                     std::ranges::none_of(text, control);
  return plain ? text : model::dump(nlohmann::json(text));
}

std::string value_line(const Dpt& type, const Value& value) {
  if (type.form == Form::kBit && same_word(type.words[0].text, type.words[1].text)) return model::to_text(value);
  if (type.form == Form::kBit) return label(type, value);
  if (type.form == Form::kEnumeration) {
    // 20.610 has the same word for 3 and 255.
    const auto text = label(type, value);
    const auto number = word_value(type.words, text);
    return number && Value(std::int64_t{*number}) == value ? text : model::to_text(value);
  }
  if (const auto* number = std::get_if<double>(&value)) {
    return fmt::format("{}", type.form == Form::kFloat32 ? natural(type, *number) : *number);
  }
  if (const auto* text = std::get_if<std::string>(&value); text && has_own_text(type)) return text_line(*text);
  return model::to_text(value);
}

std::string unquoted(std::string_view text) {
  if (!text.starts_with('"')) return std::string(text);
  const auto json = model::parse_json(text);
  return json.is_string() ? json.get<std::string>() : std::string(text);
}

}  // namespace

std::string decode_line(std::string_view line) {
  const auto input = split(line);
  if (!input) return error_line(input.error());
  auto bytes = base::from_hex(input->rest);
  if (!bytes) return error_line(bytes.error());
  const auto& type = *input->type;
  const auto value = decode(type, wire::PayloadView{*bytes, type.bits > 0 && type.bits <= 6});
  return value ? value_line(type, *value) : error_line(value.error());
}

std::string encode_line(std::string_view line) {
  const auto input = split(line);
  if (!input) return error_line(input.error());
  const auto& type = *input->type;
  const auto payload = encode_text(type, has_own_text(type) ? unquoted(input->rest) : std::string(input->rest));
  return payload ? base::to_hex(payload->bytes) : error_line(payload.error());
}

}  // namespace rubicon::networks::knx::dpt
