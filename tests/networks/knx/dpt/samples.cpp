#include "networks/knx/dpt/samples.h"

#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <set>

namespace rubicon::networks::knx::dpt {

std::vector<std::vector<std::string>> rows_of(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(file, line);) {
    std::vector<std::string> cells;
    for (std::size_t at = 0;;) {
      const auto tab = line.find('\t', at);
      cells.push_back(line.substr(at, tab - at));
      if (tab == line.npos) break;
      at = tab + 1;
    }
    rows.push_back(std::move(cells));
  }
  if (!rows.empty()) rows.erase(rows.begin());
  return rows;
}

std::string shared_file(const std::string& name) {
  return RUBICON_SOURCE_DIR "/../shared/data/knx/" + name;
}

const Dpt& dpt(std::string_view text) {
  const auto id = parse_dpt(text);
  const auto* type = id ? find_dpt(*id) : nullptr;
  if (!type) ADD_FAILURE() << "no type " << text;
  return type ? *type : all_dpts()[0];
}

wire::Payload payload(const Dpt& type, std::string_view hex) {
  return {base::from_hex(hex).value(), type.bits > 0 && type.bits <= 6};
}

std::vector<wire::Payload> payloads_of(const Dpt& type, std::size_t count) {
  const bool small = type.bits > 0 && type.bits <= 6;
  const std::size_t size = type.bits == 0 ? 20 : small ? 1 : type.bits / 8U;
  std::vector<wire::Payload> all;
  if (size <= 2) {
    // JSON is slow to write and to read: every eleventh of the 65536 has all bits in all company.
    const bool json = type.form == Form::kBits || type.form == Form::kRecord;
    const unsigned stride = json && size == 2 ? 11 : 1;
    for (unsigned raw = 0; raw < (small ? 64U : 1U << (8 * size)); raw += stride) {
      wire::Payload one{{static_cast<std::uint8_t>(raw)}, small};
      if (size == 2) one.bytes.insert(one.bytes.begin(), static_cast<std::uint8_t>(raw >> 8));
      all.push_back(std::move(one));
    }
    return all;
  }
  std::mt19937 random(type.id.main * 70000U + type.id.sub);
  for (std::size_t i = 0; i < count; ++i) {
    wire::Payload one{Bytes(size), false};
    // Every second one is sparse: zero octets and small numbers are what real payloads have.
    for (auto& byte : one.bytes) byte = static_cast<std::uint8_t>(random() % (i % 2 == 0 ? 256 : 13));
    // Random octets are hardly ever letters only.
    if (type.form == Form::kLetters) {
      for (auto& byte : one.bytes) byte = static_cast<std::uint8_t>((byte % 2 == 0 ? 'a' : 'A') + byte % 26);
    }
    all.push_back(std::move(one));
  }
  return all;
}

std::vector<const Dpt*> all_and_mains() {
  std::vector<const Dpt*> types;
  std::set<std::uint16_t> mains;
  for (const auto& type : all_dpts()) {
    types.push_back(&type);
    mains.insert(type.id.main);
  }
  for (const auto main : mains) types.push_back(find_dpt({main, DptId::kMainOnly}));
  return types;
}

}  // namespace rubicon::networks::knx::dpt
