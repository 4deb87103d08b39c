#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "networks/knx/groups/encoding.h"
#include "networks/knx/groups/group_list.h"
#include "networks/knx/groups/group_list_builder.h"

namespace rubicon::networks::knx::groups {

namespace {

/// `Main.Middle.1/0/1<TAB>name<TAB>EIS ...`: one of the first lines after the project's name looks like this.
bool is_esf(std::string_view text) {
  for (int i = 0; i < 50 && !text.empty(); ++i) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto line = text.substr(0, end);
    const auto tab = std::min(line.find('\t'), line.size());
    const auto second = std::min(line.find('\t', tab + 1), line.size());
    const auto type = line.substr(std::min(second + 1, line.size()));
    if (i > 0 && (type.starts_with("EIS ") || type.starts_with("Uncertain ("))) return true;
    const auto first = line.substr(0, tab);
    const auto dot = first.rfind('.');
    const auto address = dot == first.npos ? std::string_view() : first.substr(dot + 1);
    if (i > 0 && tab < line.size() && address.find('/') != address.npos && looks_like_address(address)) return true;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return false;
}

constexpr std::string_view kExpected =
    "expected group addresses exported from ETS as CSV, XML or ESF, in UTF-8, UTF-16 or Windows-1252";

GroupList read_lines(std::string_view text) {
  return is_esf(text) ? read_esf(text) : read_csv(text);
}

GroupList refused(std::string why) {
  GroupList list;
  list.report.refuse(0, std::move(why));
  return list;
}

}  // namespace

GroupList read_group_list(std::string_view text) {
  if (text.size() > kMaxListBytes) return refused("larger than 64 MiB: file refused");
  if (const auto name = name_of_foreign(text); !name.empty()) return refused(fmt::format("{}, {}", name, kExpected));
  auto content = text;
  if (content.starts_with(kUtf8Mark)) content.remove_prefix(kUtf8Mark.size());
  content.remove_prefix(std::min(content.find_first_not_of(" \t\r\n"), content.size()));
  if (content.empty()) return refused("empty, expected an ETS export of group addresses");
  const auto wide = utf16_of(text);
  // A parser of XML follows the declaration in the document.
  if (content.starts_with('<') || (wide && content.substr(0, 8).find('<') != content.npos)) return read_xml(text);
  if (wide) {
    const auto converted = from_utf16(text, *wide);
    return converted ? read_lines(*converted) : refused(converted.error().text);
  }
  if (const auto zero = text.find('\0'); zero != text.npos)
    return refused(fmt::format("byte {} is zero, so this is no text, {}", zero + 1, kExpected));
  return read_lines(text);
}

std::string_view to_string(Finding::Level level) {
  switch (level) {
    case Finding::Level::kNote: return "note";
    case Finding::Level::kWarning: return "warning";
    case Finding::Level::kError: return "error";
  }
  return "finding";
}

void Report::add(Finding finding) {
  const bool is_note = finding.level == Finding::Level::kNote;
  auto& count = is_note ? notes : finding.level == Finding::Level::kWarning ? warnings : errors;
  if (++count <= (is_note ? kMaxNotes : kMaxFindings)) findings.push_back(std::move(finding));
}

void Report::note(std::size_t line, std::optional<wire::GroupAddress> address, std::string text) {
  add({Finding::Level::kNote, line, address, std::move(text)});
}

void Report::warning(std::size_t line, std::optional<wire::GroupAddress> address, std::string text) {
  add({Finding::Level::kWarning, line, address, std::move(text)});
}

void Report::error(std::size_t line, std::optional<wire::GroupAddress> address, std::string text) {
  add({Finding::Level::kError, line, address, std::move(text)});
}

void Report::refuse(std::size_t line, std::string text) {
  Report empty;
  empty.source = std::move(source);
  empty.form = std::move(form);
  empty.refused = true;
  *this = std::move(empty);
  error(line, {}, std::move(text));
}

namespace {

void count(std::string& out, std::size_t number, std::string_view what) {
  if (number != 0) out += fmt::format("{}{} {}", out.empty() ? "" : ", ", number, what);
}

std::string counts_text(const Report& report) {
  std::string details;
  count(details, report.untyped, "without a type");
  count(details, report.main_type_only, "with a main type only");
  count(details, report.doubled, "duplicate");
  count(details, report.out_of_range, "out of range");
  count(details, report.secured, "secured");
  count(details, report.paired_by_project, "paired with a state address by the project");
  count(details, report.kinds_by_project, "made sensor or actuator by the project");
  count(details, report.paired, "paired with a state address by name");
  count(details, report.kinds_by_name, "made sensor or actuator by name");
  auto out = fmt::format("{}{}{}: {} group addresses imported{}{}\n", report.source, report.form.empty() ? "" : ", ",
                         report.form, report.taken, details.empty() ? "" : "; ", details);
  if (report.merged) {
    out += fmt::format("merge: {} new, {} renamed, {} unchanged, {} no longer in the import (kept)\n", report.added,
                       report.renamed, report.unchanged, report.vanished);
  }
  out += fmt::format("{} errors, {} warnings, {} notes\n", report.errors, report.warnings, report.notes);
  return out;
}

/// Text of a finding without line breaks.
std::string single_line(std::string_view text) {
  std::string out(text);
  std::replace_if(
      out.begin(), out.end(), [](unsigned char c) { return c < 0x20; }, ' ');
  return base::printable(out);
}

/// `:7`; empty for a finding that concerns no line.
std::string line_text(const Finding& finding) {
  return finding.line == 0 ? std::string() : fmt::format(":{}", finding.line);
}

}  // namespace

std::string report_text(const Report& report) {
  if (report.refused) {
    const auto& why = report.findings.front();
    return fmt::format("{}{}: {}\n", report.source, line_text(why), single_line(why.text));
  }
  auto out = counts_text(report);
  for (const auto& finding : report.findings) {
    out += fmt::format("{}{}: {}: {}{}{}\n", report.source, line_text(finding), to_string(finding.level),
                       finding.address ? to_string(*finding.address, report.notation) : std::string(),
                       finding.address ? ": " : "", single_line(finding.text));
  }
  const auto all = report.errors + report.warnings + report.notes;
  if (all > report.findings.size()) out += fmt::format("... and {} more\n", all - report.findings.size());
  return out;
}

}  // namespace rubicon::networks::knx::groups
