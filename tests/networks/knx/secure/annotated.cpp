#include "networks/knx/secure/annotated.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "networks/knx/secure/vectors.h"

namespace rubicon::networks::knx::secure {

namespace {

using Cells = std::vector<std::string>;

Cells cells_of(const std::string& line) {
  Cells cells;
  for (std::size_t at = 0;;) {
    const auto tab = line.find('\t', at);
    cells.push_back(line.substr(at, tab - at));
    if (tab == line.npos) break;
    at = tab + 1;
  }
  cells.resize(std::max<std::size_t>(cells.size(), 7));
  return cells;
}

std::string word_behind(const std::string& text, const std::string& name) {
  const auto at = text.find(name);
  if (at == text.npos) return {};
  const auto begin = at + name.size();
  return text.substr(begin, text.find(' ', begin) - begin);
}

/// A wrapper belongs to the session of its id; every other frame to the session that began last.
AnnotatedSession& session_of(std::vector<AnnotatedSession>& sessions, const Bytes& frame) {
  const auto read = wire::read_frame(frame);
  if (read && read->service == wire::ServiceCode::kSecureWrapper) {
    for (auto& session : sessions) {
      if (session.id() == wire::u16_at(read->body, 0)) return session;
    }
  }
  return sessions.back();
}

/// A replayed frame has no annotations of its own.
void annotate_replays(AnnotatedSession& session) {
  for (auto& row : session.rows) {
    for (const auto& earlier : session.rows) {
      if (!row.plain.empty() || earlier.frame != row.frame) continue;
      row.plain = earlier.plain;
      row.mac_cbc = earlier.mac_cbc;
    }
  }
}

/// seconds, kind, label, hex, note: a `plain` or `check` line belongs to the frame above.
std::vector<AnnotatedSession> read_case(std::istream& file, const std::string& name) {
  std::vector<AnnotatedSession> sessions;
  AnnotatedRow* last = nullptr;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    const auto cells = cells_of(line);
    const auto &kind = cells[1], &label = cells[2], &hex_text = cells[3];
    if (kind == "key" && label == "client private key") sessions.push_back({name, {}, {}});
    if (sessions.empty()) sessions.push_back({name, {}, {}});
    if (kind == "key") {
      sessions.back().keys[label] = hex_text;
    } else if ((kind == "C" || kind == "S") && !hex_text.empty()) {
      auto& session = session_of(sessions, hex(hex_text));
      session.rows.push_back({std::stod(cells[0]), kind[0], hex(hex_text), {}, {}, cells[4]});
      last = &session.rows.back();
    } else if (kind == "plain" && last != nullptr) {
      last->plain = hex(hex_text);
    } else if (kind == "check" && last != nullptr && hex_text.starts_with("sequence=")) {
      last->mac_cbc = word_behind(hex_text, "mac_cbc=");
    }
  }
  for (auto& session : sessions) annotate_replays(session);
  return sessions;
}

/// seconds, client, direction, service, hex, plain hex, note.
std::vector<AnnotatedSession> read_xknx(std::istream& file, const std::string& name) {
  std::map<std::string, AnnotatedSession> clients;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    const auto cells = cells_of(line);
    auto& session = clients[cells[1]];
    session.file = name + " client " + cells[1];
    const auto key = word_behind(cells[6], "session key ");
    if (!key.empty()) session.keys["session key"] = key;
    session.rows.push_back(
        {std::stod(cells[0]), cells[2][0], hex(cells[4]), hex(cells[5]), word_behind(cells[6], "mac_cbc "), cells[6]});
  }
  std::ifstream keys(shared_data("knx-secure/secure/xknx-clients-keys.txt"));
  for (std::string line; std::getline(keys, line);) {
    const auto client = word_behind(line, "xknx client ");
    if (!client.empty()) clients[client].keys["client private key"] = word_behind(line, "private key ");
  }
  std::vector<AnnotatedSession> sessions;
  for (auto& [client, session] : clients) sessions.push_back(std::move(session));
  return sessions;
}

}  // namespace

std::uint16_t AnnotatedSession::id() const {
  for (const auto& row : rows) {
    const auto frame = wire::read_frame(row.frame);
    if (frame && frame->service == wire::ServiceCode::kSessionResponse) return wire::u16_at(frame->body, 0);
  }
  return 0;
}

std::optional<std::uint8_t> AnnotatedSession::user() const {
  for (const auto& row : rows) {
    const auto frame = wire::read_frame(row.plain);
    if (frame && frame->service == wire::ServiceCode::kSessionAuthenticate) return frame->body[1];
  }
  return std::nullopt;
}

std::vector<AnnotatedSession> annotated_sessions() {
  namespace fs = std::filesystem;
  const fs::path folder = shared_data("knx-secure/secure");
  std::vector<AnnotatedSession> all;
  if (!fs::exists(folder)) return all;
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".tsv" && entry.path().stem() != "routing") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  for (const auto& path : paths) {
    std::ifstream file(path);
    const auto name = path.stem().string();
    for (auto& session : name == "xknx-sessions" ? read_xknx(file, name) : read_case(file, name))
      all.push_back(std::move(session));
  }
  return all;
}

}  // namespace rubicon::networks::knx::secure
