#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "web/access/token_file.h"
#include "web/files/page.h"

namespace rubicon::web::files {
namespace {

namespace fs = std::filesystem;

Request request_of(const std::string& path, Fields headers = {}) {
  return {.method = "GET", .path = path, .query = {}, .headers = std::move(headers), .body = {}, .caller = {}};
}

std::string field_of(const Response& response, const std::string& name) {
  for (const auto& [key, value] : response.headers) {
    if (key == name) return value;
  }
  return {};
}

const std::vector<File> kFiles{{"index.html", "<packed>", "h1", true}, {"page-0123456789ab.js", "packed", "h2", true}};

TEST(EmbeddedPage, SendsGzipWithATagAndHowLongItHolds) {
  const EmbeddedPage page(kFiles);
  const auto index = page.find(request_of("/"));
  ASSERT_TRUE(index);
  EXPECT_EQ(index->body, "<packed>");
  EXPECT_EQ(index->content_type, "text/html; charset=utf-8");
  EXPECT_EQ(field_of(*index, "Content-Encoding"), "gzip");
  EXPECT_EQ(field_of(*index, "ETag"), "\"h1\"");
  EXPECT_EQ(field_of(*index, "Cache-Control"), "no-cache");
  const auto script = page.find(request_of("/page-0123456789ab.js"));
  ASSERT_TRUE(script);
  EXPECT_EQ(field_of(*script, "Cache-Control"), "public, max-age=31536000, immutable");
  EXPECT_FALSE(page.find(request_of("/page.js")));
}

TEST(EmbeddedPage, WhoHasTheFileGetsItsTagOnly) {
  const EmbeddedPage page(kFiles);
  for (const auto* tags : {"\"h1\"", "\"x\", W/\"h1\"", "*"}) {
    const auto same = page.find(request_of("/", {{"if-none-match", tags}}));
    EXPECT_EQ(same->status, 304U) << tags;
    EXPECT_TRUE(same->body.empty());
    EXPECT_EQ(field_of(*same, "ETag"), "\"h1\"");
  }
  EXPECT_EQ(page.find(request_of("/", {{"if-none-match", "\"h2\""}}))->status, 200U);
}

TEST(EmbeddedPage, WhoTakesNoGzipIsToldSo) {
  const EmbeddedPage page(kFiles);
  const std::vector<std::pair<std::string, unsigned>> cases{
      {"gzip, deflate, br", 200}, {"*", 200}, {"gzip;q=0.5", 200}, {"identity", 406},
      {"gzip;q=0", 406},          {"", 406},  {"br", 406}};
  for (const auto& [accepted, status] : cases)
    EXPECT_EQ(page.find(request_of("/", {{"accept-encoding", accepted}}))->status, status) << accepted;
}

TEST(EmbeddedPage, IsTheOneOfTheTree) {
  std::size_t count = 0;
  for (const auto& entry : fs::directory_iterator(RUBICON_SOURCE_DIR "/web/dist")) {
    ++count;
    const auto name = entry.path().filename().string();
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(file), {});
    const auto digest = access::sha256(bytes);
    const auto found = EmbeddedPage().find(request_of("/" + name));
    ASSERT_TRUE(found) << name;
    EXPECT_EQ(field_of(*found, "ETag"), '"' + access::hex(digest.data(), digest.size()) + '"') << name;
    EXPECT_EQ(found->body.substr(0, 2), "\x1f\x8b") << name;
  }
  EXPECT_EQ(count, embedded_files().size());
  EXPECT_TRUE(EmbeddedPage().find(request_of("/")));
}

class FolderPages : public testing::Test {
 protected:
  FolderPages() : root_(testing::TempDir() + "rubicon_web_files") {
    fs::remove_all(root_);
    fs::create_directories(root_ / "page" / "parts");
    std::ofstream(root_ / "page" / "index.html") << "<html>";
    std::ofstream(root_ / "page" / "parts" / "a.js") << "a";
    std::ofstream(root_ / "page" / ".hidden") << "h";
    std::ofstream(root_ / "secret") << "s";
    fs::create_symlink(root_ / "secret", root_ / "page" / "link");
  }
  ~FolderPages() override { fs::remove_all(root_); }

  fs::path root_;
};

TEST_F(FolderPages, AreReadAtEachRequest) {
  const FolderPage page((root_ / "page").string());
  EXPECT_EQ(page.find(request_of("/"))->body, "<html>");
  EXPECT_EQ(page.find(request_of("/parts/a.js"))->content_type, "text/javascript; charset=utf-8");
  const auto before = field_of(*page.find(request_of("/")), "ETag");
  std::ofstream(root_ / "page" / "index.html") << "<new>";
  EXPECT_EQ(page.find(request_of("/"))->body, "<new>");
  EXPECT_NE(field_of(*page.find(request_of("/")), "ETag"), before);
}

TEST_F(FolderPages, HaveNothingOutside) {
  const FolderPage page((root_ / "page").string());
  for (const auto* path : {"/../secret", "/parts/../../secret", "/link", "/.hidden", "/parts", "//index.html",
                           "/%2e%2e/secret", "/parts/", "/index.html/", "/..", "/nothing"})
    EXPECT_FALSE(page.find(request_of(path))) << path;
}

}  // namespace
}  // namespace rubicon::web::files
