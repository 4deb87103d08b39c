#include "model/value.h"

#include <charconv>
#include <cmath>

namespace rubicon::model {

namespace {

template <class Number>
void write_number(Number number, std::string& out) {
  char buffer[40];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, number).ptr;
  out.assign(buffer, end);
}

struct Writer {
  std::string& out;
  void operator()(std::monostate) const { out.clear(); }
  void operator()(bool on) const { out = on ? "on" : "off"; }
  void operator()(std::int64_t number) const { write_number(number, out); }
  void operator()(double number) const {
    if (std::isfinite(number)) {
      write_number(number == 0 ? 0.0 : number, out);
    } else {
      out.clear();
    }
  }
  void operator()(const std::string& text) const { out = text; }
  void operator()(const Json& json) const { out = json.text; }
};

}  // namespace

void to_text(const Value& value, std::string& out) {
  std::visit(Writer{out}, value);
}

std::string to_text(const Value& value) {
  std::string out;
  to_text(value, out);
  return out;
}

std::string_view media_type(const Value& value) {
  return std::holds_alternative<Json>(value) ? "application/json" : "text/plain";
}

}  // namespace rubicon::model
