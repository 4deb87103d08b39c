#pragma once

#include <string>
#include <vector>

#include "base/bytes.h"
#include "networks/knx/dpt/dpt.h"

namespace rubicon::networks::knx::dpt {

/// Rows of a file of tab separated values without its head line; empty where the file is absent.
std::vector<std::vector<std::string>> rows_of(const std::string& path);
/// The reference material beside the tree: `dpt-table.tsv` -> its path.
std::string shared_file(const std::string& name);
/// The type that a text like `9.001` names; fails the test where there is none.
const Dpt& dpt(std::string_view text);
/// Payload of a type from hex; types of up to 6 bits have one octet.
wire::Payload payload(const Dpt& type, std::string_view hex);
/// Random payloads of the right form; all there are for types of up to 16 bits
/// (of JSON types of 16 bits every eleventh).
std::vector<wire::Payload> payloads_of(const Dpt& type, std::size_t count);
/// All rows and what unknown sub types fall back to.
std::vector<const Dpt*> all_and_mains();

}  // namespace rubicon::networks::knx::dpt
