#include "fuzz/rib_input.h"

#include <unistd.h>
#include <zlib.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "fuzz/scratch_folder.h"
#include "rib/reader.h"
#include "rib/writer.h"

namespace kinora::fuzz {

namespace {

constexpr std::string_view kCut = "\n##file ";
constexpr size_t kMostRewritten = 1 << 20;  // bytes of a written scene that are read again

// Names stay inside the folder.
std::string safeName(std::string_view name) {
  std::string out;
  for (char c : name.substr(0, 40))
    if (std::isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '_') out += c;
  if (out.empty() || out.find_first_not_of('.') == std::string::npos) out = "x";
  return out;
}

std::string deflate(std::string_view bytes, int windowBits) {
  z_stream z{};
  if (deflateInit2(&z, 1, Z_DEFLATED, windowBits, 8, Z_DEFAULT_STRATEGY) != Z_OK) return {};
  std::string out(deflateBound(&z, bytes.size()) + 32, '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  z.avail_in = unsigned(bytes.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = unsigned(out.size());
  deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  return out;
}

void append(std::string& s, uint32_t v, int bytes) {
  for (int i = 0; i < bytes; ++i) s += char(v >> (8 * i));
}

}  // namespace

const std::string& inputFolder() {
  static const ScratchFolder kFolder;
  return kFolder.path;
}

RibInput splitInput(std::string_view bytes) {
  RibInput in;
  size_t at = bytes.find(kCut);
  in.main = bytes.substr(0, at);
  while (at != std::string_view::npos && in.files.size() < 8) {
    const size_t name = at + kCut.size(), eol = bytes.find('\n', name);
    if (eol == std::string_view::npos) break;
    const size_t next = bytes.find(kCut, eol);
    in.files.emplace_back(safeName(bytes.substr(name, eol - name)), bytes.substr(eol + 1, next - eol - 1));
    at = next;
  }
  return in;
}

std::string joinInput(const RibInput& in) {
  std::string s = in.main;
  for (const auto& [name, bytes] : in.files) s += std::string(kCut) + name + "\n" + bytes;
  return s;
}

size_t readRibInput(std::string_view bytes) {
  const RibInput in = splitInput(bytes);
  rib::ReadOptions options;
  options.archivePath = {inputFolder()};
  // archives that multiply are bounded by counts: small here, so that the fuzzer's time goes elsewhere
  options.maxArchiveDepth = 12;
  options.maxArchiveReads = 200;
  options.checkOnly = bytes.size() % 16 == 3;
  const bool isGzip = in.main.starts_with("\x1f\x8b");
  const auto write = [](const std::string& name, const std::string& text) {
    const std::string path = inputFolder() + "/" + name;
    std::ofstream(path, std::ios::binary).write(text.data(), std::streamsize(text.size()));
    return path;
  };
  std::vector<std::string> written;
  for (const auto& [name, text] : in.files) written.push_back(write(name, text));
  std::string mainFile;
  if (isGzip || !in.files.empty()) written.push_back(mainFile = write("main.rib", in.main));

  Diagnostics messages([](const std::string&, Severity) {});
  int worlds = 0;
  rib::RibReader reader(messages, options, [&](scene::Scene&& s) {
    if (++worlds > 2) return;
    std::string text;
    rib::writeRib(s, [&](std::string_view piece) {
      if (text.size() < kMostRewritten) text += piece;
    });
    Diagnostics silent([](const std::string&, Severity) {});
    rib::RibReader again(silent, options, [](scene::Scene&&) {});
    again.readString("again.rib", std::move(text));
    again.finish();
  });
  if (mainFile.empty())
    reader.readString("main.rib", in.main);
  else
    reader.readFile(mainFile);
  reader.finish();
  for (const std::string& path : written) unlink(path.c_str());
  return messages.messages().size();
}

std::string gzipped(std::string_view bytes) { return deflate(bytes, 15 + 16); }

// A zip archive of one member (APPNOTE 4.3), without its checksum, which the reader does not look at.
std::string zipped(const std::string& member, std::string_view bytes, bool deflated) {
  const std::string data = deflated ? deflate(bytes, -15) : std::string(bytes);
  std::string common;
  append(common, 20, 2);                // version needed
  append(common, 0, 2);                 // flags
  append(common, deflated ? 8 : 0, 2);  // method
  append(common, 0, 4);                 // time
  append(common, 0, 4);                 // checksum
  append(common, uint32_t(data.size()), 4);
  append(common, uint32_t(bytes.size()), 4);
  append(common, uint32_t(member.size()), 2);
  append(common, 0, 2);  // extra field
  std::string s = "PK\3\4" + common + member + data;
  const auto directory = uint32_t(s.size());
  s += "PK\1\2";
  append(s, 20, 2);  // made by
  s += common;
  for (int i = 0; i < 14; ++i) s += '\0';  // no comment, first disk, no attributes, local header at 0
  s += member;
  const auto size = uint32_t(s.size()) - directory;
  s += "PK\5\6";
  append(s, 0, 4);
  append(s, 1, 2);
  append(s, 1, 2);
  append(s, size, 4);
  append(s, directory, 4);
  append(s, 0, 2);
  return s;
}

bool gunzipped(std::string_view bytes, std::string& out, size_t limit) {
  z_stream z{};
  if (inflateInit2(&z, 15 + 16) != Z_OK) return false;
  out.resize(limit);
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  z.avail_in = unsigned(bytes.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = unsigned(out.size());
  const int result = inflate(&z, Z_FINISH);
  out.resize(z.total_out);
  inflateEnd(&z);
  return (result == Z_OK || result == Z_STREAM_END || result == Z_BUF_ERROR) && !out.empty();
}

}  // namespace kinora::fuzz
