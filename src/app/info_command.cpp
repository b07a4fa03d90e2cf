// `kinora info FILE`: what a scene says, without building it, or what an image file holds.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "app/command_line.h"
#include "app/commands.h"
#include "app/exit_codes.h"
#include "app/plugin_path.h"
#include "base/text.h"
#include "film/tools.h"
#include "rib/reader.h"

namespace kinora::app {

namespace {

bool hasImageName(const std::string& file) {
  const std::string name = lowerCase(file);
  static constexpr std::array kExtensions{".exr", ".png", ".tif", ".tiff", ".jpg", ".jpeg",
                                          ".tex", ".tx",  ".hdr", ".bmp",  ".tga"};
  return std::any_of(kExtensions.begin(), kExtensions.end(), [&](const char* e) { return name.ends_with(e); });
}

const char* nameOf(const scene::Shape& shape) {
  static const char* const kNames[] = {"quadrics",     "polygon meshes", "subdivision meshes",
                                       "curves",       "point sets",     "patches",
                                       "patch meshes", "NURBS patches",  "other primitives"};
  static_assert(std::size(kNames) == std::variant_size_v<scene::Shape>);
  return kNames[shape.index()];
}

void printNames(const char* what, const std::map<std::string, size_t>& names) {
  if (names.empty()) return;
  fmt::print("  {:<12}", what);
  const char* separator = "";
  for (const auto& [name, count] : names) {
    fmt::print("{}{} {}", separator, count, name);
    separator = ", ";
  }
  fmt::print("\n");
}

// What a scene's primitives are and are made of; materials and shaders that several share count once.
struct Counts {
  std::map<std::string, size_t> shapes, bxdfs;
  std::map<std::string, std::map<std::string, size_t>> shaders;  // classic ones, by kind
  std::set<const void*> seen;

  void add(const std::vector<scene::PrimitivePtr>& list) {
    for (const scene::PrimitivePtr& p : list) {
      ++shapes[nameOf(p->shape)];
      if (!p->attributes) continue;
      const scene::Network* network = p->attributes->bxdf.get();
      if (network && network->terminal && seen.insert(network).second) ++bxdfs[network->terminal->plugin];
      for (const scene::NodePtr& n : p->attributes->classicShaders)
        if (n && !n->plugin.empty() && seen.insert(n.get()).second) ++shaders[n->kind][n->plugin];
    }
  }
};

void print(const scene::Scene& s) {
  fmt::print("frame {}\n", s.frame);
  if (s.resolution[0] > 0) fmt::print("  {:<12}{} x {}\n", "format", s.resolution[0], s.resolution[1]);
  for (const scene::Display& d : s.displays) fmt::print("  {:<12}{} ({}, {})\n", "display", d.file, d.driver, d.mode);
  for (const scene::Camera& c : s.cameras)
    fmt::print("  {:<12}{}{}\n", "camera", c.projection ? c.projection->plugin : "orthographic",
               c.worldToCamera.isStatic() ? "" : ", moving");
  if (s.integrator) fmt::print("  {:<12}{}\n", "integrator", s.integrator->plugin);
  std::map<std::string, size_t> lights, classicLights;
  Counts counts;
  counts.add(s.primitives);
  for (const scene::Prototype& p : s.prototypes) counts.add(p.primitives);
  for (const scene::Light& l : s.lights)
    if (l.node) ++lights[l.node->plugin];
  for (const scene::Light& l : s.classicLights)
    if (l.node) ++classicLights[l.node->plugin];
  printNames("geometry", counts.shapes);
  if (!s.prototypes.empty())
    fmt::print("  {:<12}{} of {} objects\n", "instances", s.instances.size(), s.prototypes.size());
  printNames("materials", counts.bxdfs);
  for (const auto& [kind, names] : counts.shaders) printNames(lowerCase(kind).c_str(), names);
  printNames("lights", lights);
  printNames("lightsource", classicLights);
  std::map<std::string, size_t> kept;
  for (const scene::KeptRequest& k : s.kept) ++kept[k.request];
  printNames("not rendered", kept);
}

int printScene(const std::vector<std::string>& files, const std::vector<std::string>& archivePath,
               Diagnostics& diagnostics) {
  rib::ReadOptions options;
  options.archivePath = archivePath;
  // What is said of a file on its own waits until it is known to be a scene: an archive is read again, within a world,
  // and what that one says counts.
  std::vector<std::string> held;
  Diagnostics alone([&](const std::string& line, Severity) { held.push_back(line); });
  rib::RibReader reader(alone, options, [](scene::Scene&& s) { print(s); });
  bool isRead = true;
  for (const std::string& file : files) isRead = isRead && reader.readFile(file);
  const bool isStream = std::find(files.begin(), files.end(), "-") != files.end();  // cannot be read again
  if (isRead && reader.worlds() == 0 && !isStream) {
    rib::RibReader again(diagnostics, std::move(options), [](scene::Scene&& s) { print(s); });
    fmt::print("archive, without a world of its own\n");
    again.readString("world", "WorldBegin\n");
    for (const std::string& file : files) again.readFile(file);
    again.readString("world", "\nWorldEnd\n");
    again.finish();
    return diagnostics.count("RIB-TRUNCATED") == 0 ? kComplete : kBadScene;
  }
  if (isRead) reader.finish();
  alone.summary();
  for (const std::string& line : held) fmt::print(stderr, "{}\n", line);
  return isRead && reader.worlds() > 0 && alone.count("RIB-TRUNCATED") == 0 ? kComplete : kBadScene;
}

}  // namespace

int runInfo(const Arguments& arguments) {
  Diagnostics diagnostics;
  const auto parser = makeParser("info", "What a scene says, or what an image holds.");
  std::vector<std::string> files, archivePath;
  parser->add_option("FILE", files, "RIB files, read as one stream, or an image; - is standard input")->required();
  takeOneAtATime(parser->add_option("--archive-path", archivePath, "look for archives here; may be repeated")
                     ->type_name("DIRS"));
  if (const auto done = parse(*parser, arguments, diagnostics)) return *done;
  int code = kComplete;
  if (std::none_of(files.begin(), files.end(), hasImageName)) {
    std::vector<std::string> directories;
    for (const std::string& path : archivePath)
      for (std::string& part : splitPath(path)) directories.push_back(std::move(part));
    code = printScene(files, directories, diagnostics);
  } else {
    for (const std::string& file : files) {
      const film::ToolResult result = film::imageInfo(file, diagnostics);
      fmt::print("{}", result.text);
      code = std::max(code, result.exitCode);
    }
  }
  diagnostics.summary();
  return code;
}

}  // namespace kinora::app
