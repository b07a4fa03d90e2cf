// Proves: archives with lights are read with the scene however the light is said, wherever in the file or in what it
// reads, in text, compressed and binary files, and give what the same files say without waiting; those without lights
// wait, whatever words they hold. Misses: programs, and pictures (tests/procedurals).
#include "rib/light_scan.h"

#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include <filesystem>
#include <fstream>

#include "rib/convert.h"
#include "rib/test_support.h"

namespace kinora::rib {
namespace {

Mentions mentionsOf(std::string text) { return mentionsIn(*openText(std::move(text))); }

TEST(LightScan, FindsWordsWhereverTheyStand) {
  const Mentions none =
      mentionsOf(std::string(600000, ' ') + "Sphere 1 -1 1 360 \"TrafficLight\" StreetLight \"light\"");
  EXPECT_FALSE(none.lights || none.archives || none.objects || none.conditions);
  EXPECT_FALSE(mentionsOf("").lights);
  for (const char* const word : {"Light", "LightSource", "AreaLightSource"}) {
    EXPECT_TRUE(mentionsOf(word).lights) << word;
    EXPECT_TRUE(mentionsOf("Bxdf \"PxrDiffuse\" \"b\"" + std::string(word) + " \"x\" \"y\"").lights) << word;
    // across the edges of what is read at once
    for (const size_t edge : {size_t(262144), size_t(524288)})
      for (size_t k = 0; k < 24; ++k)
        ASSERT_TRUE(mentionsOf(std::string(edge - k, '\n') + word + " \"x\"").lights) << word << " at -" << k;
  }
  const Mentions others = mentionsOf("IfBegin \"1\" ReadArchive \"a\" IfEnd ObjectInstance \"o\"");
  EXPECT_TRUE(others.archives && others.objects && others.conditions);
  EXPECT_FALSE(others.lights);
  for (size_t k = 0; k < 24; ++k)
    ASSERT_TRUE(mentionsOf(std::string(262144 - k, '\n') + "ObjectInstance \"o\"").objects) << k;
}

struct Said {
  size_t lights = 0, primitives = 0, waiting = 0;
  std::string all;
};
Said read(const std::string& file, bool delays) {
  Said out;
  Diagnostics messages([&](const std::string& line, Severity) { out.all += line + "\n"; });
  ReadOptions options;
  options.delaysProcedurals = delays;
  RibReader reader(messages, options, [&](scene::Scene&& s) {
    out.lights = s.lights.size() + s.classicLights.size();
    for (const scene::Prototype& p : s.prototypes) out.lights += p.lights.size();
    out.primitives = s.primitives.size();
    if (reader.procedurals()) out.waiting = reader.procedurals()->size();
  });
  EXPECT_TRUE(reader.readFile(file));
  reader.finish();
  return out;
}

enum class Form { Text, Compressed, Binary };
void write(const std::string& file, const std::string& text, Form form) {
  if (form == Form::Compressed) {
    gzFile out = gzopen(file.c_str(), "wb");
    ASSERT_TRUE(out);
    ASSERT_EQ(gzwrite(out, text.data(), unsigned(text.size())), int(text.size()));
    gzclose(out);
    return;
  }
  std::ofstream out(file);
  if (form == Form::Text) {
    out << text;
    return;
  }
  Diagnostics messages([](const std::string&, Severity) {});
  ConvertOptions options;
  options.binary = true;
  Converter converter(messages, options, [&](std::string_view piece) { out << piece; });
  ASSERT_TRUE(converter.text("plain.rib", text));
  converter.finish();
}

TEST(LightScan, ArchivesWithLightsDoNotWait) {
  const std::string folder = testing::TempDir() + "light-scan-" + std::to_string(::getpid());
  std::filesystem::create_directories(folder);
  const std::string ball = "Sphere .5 -.5 .5 360\n", box = "[-1 1 -1 1 -1 1]\n";
  const auto waits = [&](const char* file) {
    return "Procedural \"DelayedReadArchive\" [\"" + std::string(file) + "\"] " + box;
  };
  const auto waits2 = [&](const char* file) {
    return "Procedural2 \"DelayedReadArchive2\" \"SimpleBound\" \"string filename\" [\"" + std::string(file) +
           "\"] \"float[6] bound\" " + box;
  };
  struct Light {
    const char* name;
    std::string text;
    size_t lights;
  };
  const Light kLights[] = {
      {"a light", "Light \"PxrSphereLight\" \"l\"\n", 1},
      {"a dome", "AttributeBegin\nScale 2 2 2\nLight \"PxrDomeLight\" \"l\" \"float intensity\" [1]\nAttributeEnd\n",
       1},
      {"of a mesh", "AttributeBegin\nLight \"PxrMeshLight\" \"l\"\nSphere .1 -.1 .1 360\nAttributeEnd\n", 1},
      {"classic", "LightSource \"pointlight\" 3\n", 1},
      {"an area", "AttributeBegin\nAreaLightSource \"arealight\" 3\nSphere .1 -.1 .1 360\nAttributeEnd\n", 1},
      {"in an object", "ObjectBegin \"own\"\nLight \"PxrSphereLight\" \"l\"\nObjectEnd\nObjectInstance \"own\"\n", 1},
      {"none", "Attribute \"identifier\" \"string name\" [\" Light \"]\n", 0},
      {"not here", "IfBegin \"0\"\nLight \"PxrSphereLight\" \"l\"\nIfEnd\n", 0},
  };
  const char* const kPlaces[] = {"itself", "in what it reads", "in what waits in it", "two deep"};
  for (const Form form : {Form::Text, Form::Compressed, Form::Binary})
    for (const Light& light : kLights)
      for (const char* const place : kPlaces)
        for (const bool isSecond : {false, true}) {
          const std::string where = std::string(light.name) + " " + place + " form " + std::to_string(int(form));
          write(folder + "/l.rib", ball + light.text, form);
          write(folder + "/m.rib", "ReadArchive \"l.rib\"\n", form);
          write(folder + "/a.rib",
                place == kPlaces[0]   ? ball + light.text
                : place == kPlaces[1] ? ball + "ReadArchive \"l.rib\"\n"
                : place == kPlaces[2] ? ball + waits("l.rib")
                                      : ball + waits2("m.rib"),
                form);
          write(folder + "/b.rib", ball, form);
          write(folder + "/s.rib",
                "WorldBegin\n" + (isSecond ? waits2("a.rib") : waits("a.rib")) + waits("b.rib") + waits("a.rib") +
                    "WorldEnd\n",
                Form::Text);
          const Said now = read(folder + "/s.rib", false), later = read(folder + "/s.rib", true);
          EXPECT_EQ(now.lights, 2 * light.lights) << where;
          EXPECT_EQ(later.lights, now.lights) << where << later.all;
          EXPECT_EQ(later.waiting, light.lights ? 1u : 3u) << where;
          if (light.lights) {
            EXPECT_EQ(later.primitives, now.primitives) << where;
          }
        }
  // what is missing or reads itself is no message before it is met
  write(folder + "/a.rib", ball + waits("a.rib") + waits("gone.rib") + "ReadArchive \"gone.rib\"\n", Form::Text);
  write(folder + "/s.rib", "WorldBegin\n" + waits("a.rib") + waits("gone.rib") + "WorldEnd\n", Form::Text);
  const Said quiet = read(folder + "/s.rib", true);
  EXPECT_EQ(quiet.all, "");
  EXPECT_EQ(quiet.waiting, 2u);
  // a light behind the place where it reads itself
  write(folder + "/a.rib", ball + waits("b.rib") + "Light \"PxrSphereLight\" \"l\"\n", Form::Text);
  write(folder + "/b.rib", ball + waits("a.rib"), Form::Text);
  EXPECT_EQ(read(folder + "/s.rib", true).lights, 1u);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace kinora::rib
