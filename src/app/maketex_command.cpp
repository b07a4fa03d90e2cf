// `kinora maketex IN [OUT]`; the making is texture/make_texture.h's. Flags may be spelt as txmake spells them, with
// one dash.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <CLI/Validators.hpp>
#include <fmt/format.h>

#include <filesystem>
#include <set>

#include "app/command_line.h"
#include "app/commands.h"
#include "app/exit_codes.h"
#include "base/text.h"
#include "texture/make_texture.h"

namespace kinora::app {

namespace {

// "-mode" becomes "--mode"; what is no flag of ours stays, so that the parser names it as it was written.
Arguments withTwoDashes(const Arguments& arguments) {
  static const std::set<std::string> kFlags{"mode",      "smode",       "tmode", "resize",    "filter",  "format",
                                            "byte",      "short",       "half",  "float",     "envlatl", "newer",
                                            "verbose",   "compression", "nomip", "linearize", "tile",    "threads",
                                            "mipfilter", "pattern",     "blur",  "ch"};
  Arguments out;
  for (const std::string& a : arguments) {
    // txmake's -t:4 is a number of threads
    if (a.rfind("-t:", 0) == 0)
      out.insert(out.end(), {"--threads", a.substr(3)});
    else
      out.push_back(a.size() > 2 && a[0] == '-' && a[1] != '-' && kFlags.count(a.substr(1)) ? "-" + a : a);
  }
  return out;
}

// By the name; a number behind a colon is its quality.
bool isCompression(const std::string& text) {
  static const std::set<std::string> kNames{"none", "lzw", "zip", "zips",  "deflate", "packbits", "ccittrle", "zstd",
                                            "jpeg", "rle", "piz", "pxr24", "b44",     "b44a",     "dwaa",     "dwab"};
  return kNames.count(lowerCase(text.substr(0, text.find(':')))) > 0;
}

bool isNewer(const std::string& output, const std::string& input) {
  std::error_code a, b;
  const auto made = std::filesystem::last_write_time(output, a), from = std::filesystem::last_write_time(input, b);
  return !a && !b && made > from;
}

}  // namespace

int runMaketex(const Arguments& arguments) {
  Diagnostics diagnostics;
  const auto parser =
      makeParser("maketex",
                 "Makes a tiled, mip-mapped texture of an image of any format. Flags may be written with one "
                 "dash, as txmake takes them.");
  std::string input, output, mode, mipFilter, pattern, channels;
  float blur = 1;
  texture::MakeTextureOptions o;
  bool byte = false, shorts = false, half = false, floats = false, newer = false, verbose = false, flat = false;
  const CLI::IsMember wraps({"black", "clamp", "periodic", "mirror"});
  parser->add_option("IN", input, "an image")->required();
  parser->add_option("OUT", output, "the texture (IN with the ending .tx)");
  parser->add_option("--mode", mode, "what lies beyond the edges: periodic, black, clamp, mirror (periodic)")
      ->check(wraps);
  parser->add_option("--smode", o.wrapS, "the same, of s alone")->check(wraps);
  parser->add_option("--tmode", o.wrapT, "the same, of t alone")->check(wraps);
  parser->add_option("--resize", o.resize, "sides to powers of two: up, down, round, none (none)")
      ->check(CLI::IsMember({"up", "down", "round", "none", "up-", "down-", "round-"}));
  const CLI::IsMember filters({"point", "box", "triangle", "catmull-rom", "gaussian", "gaussian-soft", "sinc",
                               "lanczos", "lanczos3", "cubic", "mitchell", "bspline", "blackman-harris"});
  parser->add_option("--filter", o.filter, "filter of the mip levels (box)")->check(filters);
  parser->add_option("--mipfilter", mipFilter, "the same; it comes before --filter")->check(filters);
  parser
      ->add_option("--pattern", pattern, "diagonal: mip levels; single: none; all: not made, as diagonal (diagonal)")
      ->check(CLI::IsMember({"diagonal", "single", "all"}));
  parser->add_option("--blur", blur, "no effect: the filter has the width that is its own");
  parser->add_option("--ch", channels, "no effect: all channels are kept");
  parser->add_option("--format", o.format, "tiff, openexr; pixar becomes tiff (by the ending)")
      ->check(CLI::IsMember({"tiff", "openexr", "pixar"}));
  parser->add_flag("--byte", byte, "8-bit integers");
  parser->add_flag("--short", shorts, "16-bit integers");
  parser->add_flag("--half", half, "16-bit floats");
  parser->add_flag("--float", floats, "32-bit floats");
  parser->add_option("--compression", o.compression, "of the file: zip, lzw, piz, none, ...");
  parser->add_flag("--envlatl", o.latlong, "an environment map of latitudes and longitudes");
  parser->add_flag("--linearize", o.linearize, "decode sRGB to linear light, for linearize 0");
  parser->add_flag("--nomip", flat, "tiles only, no mip levels");
  parser->add_option("--tile", o.tileSize, "side of a tile, pixels (64)")->check(CLI::Range(8, 4096));
  parser->add_option("--threads", o.threads, "threads (all)")->check(CLI::Range(0, 4096));
  parser->add_flag("--newer", newer, "do nothing where OUT is newer than IN");
  parser->add_flag("--verbose", verbose, "say what is done");
  if (const auto done = parse(*parser, withTwoDashes(arguments), diagnostics)) return *done;
  if (int(byte) + shorts + half + floats > 1)
    return badCommandLine(diagnostics, "only one of --byte, --short, --half and --float can be the type");
  if (!o.compression.empty() && !isCompression(o.compression))
    return badCommandLine(
        diagnostics, "--compression: no compression is called '" + o.compression + "'",
        "of TIFF there are none, lzw, zip, packbits; of OpenEXR none, rle, zip, zips, piz, pxr24, b44, "
        "b44a, dwaa, dwab");
  std::string ignored;
  for (const auto& [isGiven, flag] :
       {std::pair(pattern == "all", "--pattern all: levels are half as large both ways"),
        {blur != 1, "--blur: the filter has a width of its own"},
        {!channels.empty(), "--ch: all channels are kept"}})
    if (isGiven) ignored += (ignored.empty() ? "" : "; ") + std::string(flag);
  if (!ignored.empty()) diagnostics.warning("APP-TXMAKE", {}, "flags that are not supported are ignored", ignored);
  if (output.empty()) output = std::filesystem::path(input).replace_extension(".tx").string();
  if (isOverInput(diagnostics, output, {input})) return kBadCommandLine;
  if (!mode.empty()) {
    if (!parser->count("--smode")) o.wrapS = mode;
    if (!parser->count("--tmode")) o.wrapT = mode;
  }
  // spellings of OpenImageIO
  if (!mipFilter.empty()) o.filter = mipFilter;
  if (o.filter == "lanczos") o.filter = "lanczos3";
  if (o.filter == "bspline") o.filter = "b-spline";
  if (o.filter == "gaussian-soft") o.filter = "gaussian";
  if (o.filter == "point") o.filter = "box";
  o.type = byte ? "byte" : shorts ? "short" : half ? "half" : floats ? "float" : "";
  o.mipMapped = !flat && pattern != "single";
  if (newer && isNewer(output, input)) {
    if (verbose) fmt::print("{} is up to date\n", output);
    return kComplete;
  }
  std::string why;
  switch (texture::makeTexture(input, output, o, why)) {
    case texture::MakeTextureResult::BadInput:
      diagnostics.error("ASSET-TEXTURE-READ", {}, "'" + input + "' cannot be made a texture: " + why,
                        "nothing was written");
      return kBadScene;
    case texture::MakeTextureResult::CannotWrite:
      diagnostics.error("APP-WRITE", {}, "'" + output + "' cannot be written: " + why, "nothing was written");
      return kCannotWrite;
    case texture::MakeTextureResult::Made:
      break;
  }
  if (verbose) fmt::print("wrote {}\n", output);
  return kComplete;
}

}  // namespace kinora::app
