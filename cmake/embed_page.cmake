# cmake -D FILES=a;b -D OUTPUT=x.cpp -P embed_page.cmake: the files of the page as gzip, each with the SHA-256 of the file.
set(arrays "")
set(table "")
set(number 0)
foreach(file ${FILES})
  get_filename_component(name ${file} NAME)
  set(packed ${OUTPUT}.${number}.gz)
  execute_process(COMMAND gzip -9nc ${file} OUTPUT_FILE ${packed} COMMAND_ERROR_IS_FATAL ANY)
  file(READ ${packed} bytes HEX)
  file(REMOVE ${packed})
  file(SHA256 ${file} hash)
  string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
  string(APPEND arrays "constexpr unsigned char kFile${number}[] = {${bytes}};\n")
  string(APPEND table "    {\"${name}\", {reinterpret_cast<const char*>(kFile${number}), sizeof kFile${number}}, \"${hash}\", true},\n")
  math(EXPR number "${number} + 1")
endforeach()
file(WRITE ${OUTPUT}.new
"#include \"web/files/page.h\"

namespace rubicon::web::files {

namespace {
${arrays}}  // namespace

std::vector<File> embedded_files() {
  return {
${table}  };
}

}  // namespace rubicon::web::files
")
file(RENAME ${OUTPUT}.new ${OUTPUT})
