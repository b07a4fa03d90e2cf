// `kinora rib`: RIB as ASCII or binary, compressed or not, with archives expanded. The work is rib/convert.h's.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <unistd.h>
#include <zlib.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <optional>

#include "app/command_line.h"
#include "app/commands.h"
#include "app/exit_codes.h"
#include "app/plugin_path.h"
#include "image/atomic_file.h"
#include "rib/convert.h"
#include "rib/reader.h"
#include "rib/writer.h"

namespace kinora::app {

namespace {

// Bytes to a file or to standard output, through gzip when asked for. A file appears whole or not at all.
class RibFile {
 public:
  // `name` "": standard output.
  RibFile(const std::string& name, bool isGzip) : name_(name) {
    if (!name.empty()) target_.emplace(name);
    if (isGzip)
      gzip_ = name.empty() ? gzdopen(dup(1), "wb") : gzopen(target_->path().c_str(), "wb");
    else
      file_ = name.empty() ? stdout : std::fopen(target_->path().c_str(), "wb");
    if (!gzip_ && !file_) fail();
  }
  ~RibFile() { close(); }
  RibFile(const RibFile&) = delete;

  void write(std::string_view text) {
    if (!why_.empty() || text.empty()) return;
    const bool isWritten = gzip_ ? gzwrite(gzip_, text.data(), unsigned(text.size())) == int(text.size())
                                 : std::fwrite(text.data(), 1, text.size(), file_) == text.size();
    if (!isWritten) fail();
  }
  // "" when all is written, else why not.
  std::string commit() {
    close();
    if (why_.empty() && target_)
      if (const image::Status s = target_->commit(); !s.ok()) why_ = s.what;
    return why_;
  }

 private:
  void fail() {
    if (why_.empty())
      why_ = "cannot write \"" + (name_.empty() ? "standard output" : name_) +
             "\": " + std::strerror(errno ? errno : EIO);
  }
  void close() {
    if (gzip_ && gzclose(gzip_) != Z_OK) fail();
    if (file_ && (name_.empty() ? std::fflush(file_) : std::fclose(file_)) != 0) fail();
    gzip_ = nullptr;
    file_ = nullptr;
  }
  std::string name_, why_;
  std::optional<image::AtomicFile> target_;
  gzFile gzip_ = nullptr;
  std::FILE* file_ = nullptr;
};

struct RibOptions {
  std::vector<std::string> files;
  std::string output;
  bool isAscii = false, isBinary = false, isGzip = false, isExpanded = false, isResolved = false, isStrict = false;
  std::vector<std::string> searchPaths, dirmaps;
};

// What the reader understood, written as ASCII.
bool resolve(const std::vector<std::string>& files, const rib::ConvertOptions& paths, Diagnostics& diagnostics,
             std::string& text) {
  rib::ReadOptions reading;
  reading.archivePath = paths.archivePath;
  reading.dirmap = paths.dirmap;
  rib::RibReader reader(diagnostics, std::move(reading), [&](scene::Scene&& s) { text += rib::writeRib(s); });
  for (const std::string& file : files)
    if (!reader.readFile(file)) return false;
  reader.finish();
  return reader.worlds() > 0;
}

}  // namespace

int runRib(const Arguments& arguments) {
  Diagnostics diagnostics;
  const auto parser =
      makeParser("rib",
                 "Writes RIB as ASCII (default) or binary, compressed or not. Requests stay as they are; "
                 "comments go. Input may be ASCII, binary, gzip.");
  RibOptions o;
  parser->add_option("FILE", o.files, "RIB files, read as one stream; - is standard input");
  parser->add_option("-o,--output", o.output, "write here instead of standard output; .gz compresses")
      ->type_name("FILE");
  auto* ascii = parser->add_flag("--ascii", o.isAscii, "write ASCII");
  parser->add_flag("--binary", o.isBinary, "write binary RIB")->excludes(ascii);
  parser->add_flag("--gzip", o.isGzip, "compress");
  parser->add_flag("--expand", o.isExpanded, "put archives in the place of the requests that read them");
  parser->add_flag(
      "--resolve", o.isResolved,
      "write what Kinora understood: conditions decided, archives read, transforms and defaults worked out");
  takeOneAtATime(
      parser->add_option("--search-path", o.searchPaths, "look for archives here too")->type_name("archive=DIRS"));
  takeOneAtATime(
      parser->add_option("--dirmap", o.dirmaps, "replace the start of the names of archives")->type_name("FROM=TO"));
  parser->add_flag("--strict", o.isStrict, "a missing archive is an error (exit code 4)");
  if (const auto done = parse(*parser, arguments, diagnostics)) return *done;
  if (o.files.empty()) return badCommandLine(diagnostics, "no RIB file is named", "see `kinora rib --help`");

  if (isOverInput(diagnostics, o.output, o.files)) return kBadCommandLine;
  rib::ConvertOptions options;
  options.binary = o.isBinary;
  options.expand = o.isExpanded;
  for (const std::string& path : o.searchPaths) {
    if (!path.starts_with("archive="))
      return badCommandLine(diagnostics, "--search-path '" + path + "' is not archive=DIRS");
    for (std::string& directory : splitPath(path.substr(8))) options.archivePath.push_back(std::move(directory));
  }
  for (const std::string& map : o.dirmaps)
    if (!parseDirmap(map, options.dirmap))
      return badCommandLine(diagnostics, "--dirmap '" + map + "' is not FROM=TO");
  std::string resolved;
  if (o.isResolved && !resolve(o.files, options, diagnostics, resolved)) {
    diagnostics.summary();
    return kBadScene;
  }

  if (!o.output.empty())
    if (const image::Status s = image::AtomicFile(o.output).probe(); !s.ok()) {
      diagnostics.error("APP-WRITE", {}, s.what, "nothing was converted", "name a file in a folder that exists");
      return kCannotWrite;
    }
  RibFile out(o.output, o.isGzip || o.output.ends_with(".gz"));
  rib::Converter converter(diagnostics, options, [&](std::string_view text) { out.write(text); });
  bool isRead = true;
  if (o.isResolved)
    isRead = converter.text("resolved", std::move(resolved));
  else
    for (const std::string& file : o.files) isRead = isRead && converter.file(file);
  converter.finish();
  int code = kComplete;
  if (!isRead || diagnostics.count("RIB-TRUNCATED") > 0) code = kBadScene;
  if (code == kComplete && o.isStrict && diagnostics.assetProblems() > 0) code = kMissingAsset;
  if (code == kComplete)
    if (const std::string why = out.commit(); !why.empty()) {
      diagnostics.error("APP-WRITE", {}, why, "what was there before is kept");
      code = kCannotWrite;
    }
  diagnostics.summary();
  return code;
}

}  // namespace kinora::app
