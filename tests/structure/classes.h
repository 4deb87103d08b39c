#pragma once

#include <algorithm>
#include <cctype>
#include <regex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace rubicon::structure {

/// A class as its body declares it: not with what it inherits, and not with what its own types have.
struct ClassText {
  std::string name;                  ///< with what it is nested in, if that is written before it: `Node::Impl`
  std::vector<std::string> members;  ///< a declaration for each function and each variable, constants too
  std::string body;
};

/// The end of a comment, or of a text in quotation marks, that begins at `begin`; `begin`: there is none.
inline std::size_t end_of_no_code(std::string_view text, std::size_t begin) {
  const auto after = [&](std::string_view end, std::size_t from) {
    const auto found = text.find(end, from);
    return found == text.npos ? text.size() : found + end.size();
  };
  const auto rest = text.substr(begin);
  if (rest.starts_with("//") || rest.starts_with("#")) {
    auto end = text.find('\n', begin);
    while (end != text.npos && text[end - 1] == '\\') end = text.find('\n', end + 1);
    return std::min(end, text.size());
  }
  if (rest.starts_with("/*")) return after("*/", begin + 2);
  if (rest.starts_with("R\"")) {
    const auto open = text.find('(', begin);
    return after(")" + std::string(text.substr(begin + 2, open - begin - 2)) + "\"", open);
  }
  const bool separates_digits = begin > 0 && std::isalnum(static_cast<unsigned char>(text[begin - 1])) != 0;
  if (rest[0] != '"' && (rest[0] != '\'' || separates_digits)) return begin;
  for (auto at = begin + 1; at < text.size(); at += text[at] == '\\' ? 2U : 1U) {
    if (text[at] == rest[0]) return at + 1;
  }
  return text.size();
}

/// The text without comments, preprocessor lines, and what is in quotation marks.
inline std::string code_of(std::string_view text) {
  std::string code;
  for (std::size_t at = 0; at < text.size();) {
    const auto end = end_of_no_code(text, at);
    if (end == at) code += text[at++];
    at = std::max(at, end);
  }
  return code;
}

/// The end of what begins with the brace at `begin`.
inline std::size_t closing_brace(std::string_view code, std::size_t begin) {
  std::size_t depth = 0;
  for (auto at = begin; at < code.size(); ++at) {
    if (code[at] == '{') ++depth;
    if (code[at] == '}' && --depth == 0) return at;
  }
  return code.size();
}

/// Without template arguments and access.
inline std::string plain(std::string declaration) {
  static const std::regex kAccess(R"re(^\s*(?:(?:public|private|protected)\s*:\s*|\{\})*)re"), kInner("<[^<>]*>");
  declaration = std::regex_replace(declaration, kAccess, "");
  if (declaration.find("operator") == declaration.npos) {
    for (std::string before; before != declaration;) {
      before = declaration;
      declaration = std::regex_replace(declaration, kInner, "");
    }
  }
  return declaration;
}

/// The declarations of a body; a brace and what it encloses is `{}`.
inline std::vector<std::string> declarations_of(std::string_view body) {
  static const std::regex kType(R"re(^\s*(?:class|struct|enum|union)\b)re");
  std::vector<std::string> all;
  std::string present;
  int parentheses = 0;
  for (std::size_t at = 0; at < body.size(); ++at) {
    const char c = body[at];
    parentheses += c == '(' ? 1 : c == ')' ? -1 : 0;
    if (c == '{') {
      at = closing_brace(body, at);
      present += "{}";
      const auto next = body.find_first_not_of(" \t\n", at + 1);
      const bool goes_on = parentheses > 0 || (next != body.npos && (body[next] == ';' || body[next] == ','));
      const auto head = plain(present);
      if (!goes_on && head.find('(') != head.npos && !std::regex_search(head, kType))
        all.push_back(std::exchange(present, {}));
    } else if (c == ';' && parentheses == 0) {
      all.push_back(std::exchange(present, {}));
    } else {
      present += c;
    }
  }
  return all;
}

/// The variables that one declaration has, as many declarations; none if it declares a type.
inline std::vector<std::string> members_of(const std::string& declaration) {
  static const std::regex kNone(R"re(^\s*(?:$|using\b|friend\b|typedef\b|static_assert\b|template[^;]*friend\b))re"),
      kType(R"re(^(?:class|struct|enum|union)\b(?:[^{]*\{\}\s*$|[^{]*$))re");
  const auto text = plain(declaration);
  if (std::regex_search(text, kNone) || std::regex_search(text, kType)) return {};
  const bool is_operator = text.find("operator") != text.npos;
  if (is_operator || text.substr(0, text.find_first_of("{=")).find('(') != text.npos) return {text};
  std::vector<std::string> all{{}};
  int parentheses = 0;
  for (const char c : text) {
    parentheses += c == '(' ? 1 : c == ')' ? -1 : 0;
    if (c == ',' && parentheses == 0) {
      all.emplace_back();
    } else {
      all.back() += c;
    }
  }
  return all;
}

/// All classes and structs that a file defines, the nested ones too.
inline std::vector<ClassText> classes_of(const std::string& text) {
  static const std::regex kBegin(R"re(\b(enum\s+)?(?:class|struct)\s+([\w:]+)(?:\s+final)?(?:\s*:[^;{()]*)?\s*\{)re");
  std::vector<ClassText> all;
  const auto code = code_of(text);
  for (std::sregex_iterator it(code.begin(), code.end(), kBegin), end; it != end; ++it) {
    if ((*it)[1].matched) continue;
    const auto begin = static_cast<std::size_t>(it->position() + it->length());
    const auto body = code.substr(begin, closing_brace(code, begin - 1) - begin);
    ClassText one{(*it)[2], {}, body};
    for (const auto& declaration : declarations_of(body)) {
      for (auto& member : members_of(declaration)) one.members.push_back(std::move(member));
    }
    all.push_back(std::move(one));
  }
  return all;
}

}  // namespace rubicon::structure
