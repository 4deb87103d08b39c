#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <sstream>

#include "structure/classes.h"
#include "structure/tree.h"

namespace rubicon::structure {
namespace {

/// A row of a table: `Class::function`, and the file of the folder in the heading before it.
struct Step {
  std::string function, path;
};

std::vector<Step> steps_of(const std::string& page) {
  static const std::regex kHeading(R"re(^## .*: `(src/[\w/]+)`$)re"),
      kRow(R"re(^\| [^|]* \| `([\w:]+::\w+)` \| `(\w+\.\w+)` \|)re");
  std::vector<Step> all;
  std::string folder;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    std::smatch found;
    if (std::regex_search(line, found, kHeading)) folder = found[1];
    if (std::regex_search(line, found, kRow)) all.push_back({found[1], folder + "/" + found[2].str()});
  }
  return all;
}

/// Whether it is a sequence of names at the end of another one: `Impl` of `Node::Impl`.
bool ends_with_name(const std::string& name, const std::string& end) {
  return name == end || name.ends_with("::" + end) || end.ends_with("::" + name);
}

/// Whether the text has the body of a function, outside of its class or in it.
bool has_body(const std::string& text, const std::string& function) {
  if (std::regex_search(code_of(text), std::regex("\\b" + function + R"re(\([^;{}]*\) (?:const )?\{)re"))) return true;
  const auto split = function.rfind("::");
  const std::regex in_class("\\b" + function.substr(split + 2) + R"re(\([^;{}]*\) (?:const |override )*\{)re");
  for (const auto& one : classes_of(text)) {
    if (ends_with_name(one.name, function.substr(0, split)) && std::regex_search(one.body, in_class)) return true;
  }
  return false;
}

TEST(LifeOfAFrame, EachFunctionIsInItsFile) {
  const auto steps = steps_of(read_text(root_folder() / "docs/life-of-a-frame.md"));
  EXPECT_GE(steps.size(), 60U);
  std::set<std::string> folders;
  for (const auto& step : steps) {
    folders.insert(step.path.substr(0, step.path.rfind('/')));
    EXPECT_TRUE(has_body(read_text(root_folder() / step.path), step.function)) << step.function << " in " << step.path;
  }
  EXPECT_EQ(folders, (std::set<std::string>{"src/tuples", "src/tuples/dds", "src/tuples/host", "src/tuples/joined",
                                            "src/tuples/mqtt", "src/tuples/peis"}));
}

/// What a page names as `Class::function`, anywhere in its text.
std::set<std::string> functions_of(const std::string& page) {
  static const std::regex kName(R"re(`([A-Z]\w*(?:::\w+)+)`)re");
  std::set<std::string> names;
  for (std::sregex_iterator it(page.begin(), page.end(), kName), end; it != end; ++it) names.insert((*it)[1]);
  return names;
}

/// Whether the text has the body of a function; quick where it does not even name the function and its class.
bool defines(const std::string& text, const std::string& function) {
  const auto split = function.rfind("::");
  const auto of_class = function.substr(0, split);
  const auto innermost = of_class.substr(of_class.rfind(':') + 1);
  return text.find(function.substr(split + 2) + "(") != text.npos && text.find(innermost) != text.npos &&
         has_body(text, function);
}

/// What the text names besides is somewhere in the folders of the wires.
TEST(LifeOfAFrame, NamesNothingThatIsNotThere) {
  const auto page = read_text(root_folder() / "docs/life-of-a-frame.md");
  const auto files = files_below("src/tuples", {".h", ".cpp"});
  auto names = functions_of(page);
  for (const auto& step : steps_of(page)) names.erase(step.function);
  EXPECT_FALSE(names.empty());
  for (const auto& name : names) {
    EXPECT_TRUE(std::ranges::any_of(files, [&](const auto& file) { return defines(file.text, name); })) << name;
  }
}

TEST(LifeOfAReading, ItsPageAndThatOfACommandNameNothingThatIsNotThere) {
  const auto files = files_below("src", {".h", ".cpp"});
  for (const auto* page : {"docs/life-of-a-reading.md", "docs/life-of-a-command.md"}) {
    const auto names = functions_of(read_text(root_folder() / page));
    EXPECT_GE(names.size(), 15U) << page;
    for (const auto& name : names) {
      EXPECT_TRUE(std::ranges::any_of(files, [&](const auto& file) { return defines(file.text, name); }))
          << name << " in " << page;
    }
  }
}

TEST(LifeOfAFrame, AMissingFunctionIsFound) {
  const std::string text =
      "struct Link::Reader : Base {\n  void on_set(Set&& set) override { take(set); }\n};\n"
      "bool Link::take(int a) const {\n}\nvoid gone();\n";
  EXPECT_TRUE(has_body(text, "Link::take"));
  EXPECT_TRUE(has_body(text, "Link::Reader::on_set"));
  EXPECT_FALSE(has_body(text, "Link::on_set"));
  EXPECT_FALSE(has_body(text, "Link::gone"));
}

}  // namespace
}  // namespace rubicon::structure
