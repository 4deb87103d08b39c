#include <fmt/format.h>

#include <algorithm>

#include "base/printable.h"
#include "networks/knx/groups/group_list.h"

namespace rubicon::networks::knx::groups {

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
