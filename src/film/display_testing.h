// What the tests of displays share: the stock drivers, a folder of its own for each test, scenes of displays and
// films for their plans.
#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "film/display_output.h"
#include "film/film_test_samples.h"
#include "base/folder_test.h"
#include "plugin/registry.h"

namespace kinora::film::test {

inline const Descriptor* stockDriver(const std::string& name) {
  static Registry registry;
  static Diagnostics diagnostics([](const std::string&, Severity) {});
  return registry.find(Kind::Display, name, diagnostics, {});
}

inline scene::Parameter text(const char* name, const char* value) {
  scene::Parameter p;
  p.name = name;
  p.type = scene::ValueType::String;
  p.strings = {value};
  return p;
}
inline scene::Parameter integer(const char* name, std::vector<int> values) {
  scene::Parameter p;
  p.name = name;
  p.type = scene::ValueType::Int;
  p.arrayLength = int(values.size());
  p.isArray = values.size() > 1;
  p.ints = std::move(values);
  return p;
}

class DisplayTest : public kinora::test::FolderTest {
 protected:
  scene::Display& display(const std::string& file, const char* driver, const char* mode) {
    scene_.displays.push_back({file, driver, mode, {}, {}});
    return scene_.displays.back();
  }
  scene::DisplayChannel& channel(const char* name, scene::ValueType type) {
    scene_.channels.push_back({name, type, 1, {}, {}});
    return scene_.channels.back();
  }
  DisplayPlan plan(const std::string& output = {}) {
    return planDisplays(scene_, {output, false, false}, stockDriver, diagnostics_);
  }
  static std::vector<std::string> names(const Output& o) {
    std::vector<std::string> list;
    for (const OutputChannel& c : o.channels) list.insert(list.end(), c.names.begin(), c.names.end());
    return list;
  }
  // A film of the plan's layout with random samples, 3 of 4 pixels of every channel filled.
  std::unique_ptr<Film> filmFor(const ChannelLayout& layout, Window window = {}) {
    auto film = test::makeFilm(24, 20, layout, window);
    test::randomSamples(layout, film->window(), 4, 1).addTo(*film);
    return film;
  }
  static FrameMetadata frame() {
    FrameMetadata f;
    f.frame = 12;
    f.seed = 1ull << 60;
    f.samples = {{0, 4}};
    f.samplesPerPixel = 4;
    f.renderSeconds = 2;
    f.kinoraVersion = "0.1.0";
    f.sceneHash = "cafe";
    f.worldToCamera[12] = 5;
    return f;
  }
  using Names = std::vector<std::string>;
  scene::Scene scene_;
  std::vector<std::string> lines_;
  Diagnostics diagnostics_{[this](const std::string& line, Severity) { lines_.push_back(line); }};
};

}  // namespace kinora::film::test
