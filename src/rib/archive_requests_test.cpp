// What archives and programs that write RIB leave in the scene description.
#include <chrono>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <variant>

#include "rib/test_support.h"
#include "scene/digests.h"
#include "scene/procedural.h"

namespace kinora::rib {
namespace {

using namespace scene;

TEST(Archives, InlineOnesAreReplayedAndSubstituted) {
  const Read r = readWorld(R"(ArchiveBegin "ball"
ArchiveBegin "inner"
Sphere 1 -1 1 360
ArchiveEnd
Attribute "identifier" "string name" ["${user:who}"]
ReadArchive "inner"
ArchiveEnd
Attribute "user" "string who" ["ann"]
ReadArchive "ball"
Attribute "user" "string who" ["bob"]
ReadArchive "ball")");
  expectClean(r);
  ASSERT_EQ(r.world().primitives.size(), 2u);
  EXPECT_EQ(r.primitive(0).name(), "ann");
  EXPECT_EQ(r.primitive(1).name(), "bob");
}

TEST(Archives, DelayedOnesAreReadInAScopeOfTheirOwn) {
  const Read r = readWorld(
      "ArchiveBegin \"a\"\nColor 1 0 0\nTranslate 1 0 0\nSphere 1 -1 1 360\nArchiveEnd\n"
      "Procedural \"DelayedReadArchive\" [\"a\"] [0 1 0 1 0 1]\n"
      "Procedural2 \"DelayedReadArchive2\" \"SimpleBound\" \"string filename\" [\"a\"] \"float[6] bound\" [0 1 0 1 0 "
      "1]\n"
      "Sphere 2 -2 2 360");
  expectClean(r);
  ASSERT_EQ(r.world().primitives.size(), 3u);
  EXPECT_EQ(r.primitive(1).toWorld.matrices[0][3][0], 1);
  EXPECT_FALSE(r.primitive(2).attributes->color);
  EXPECT_EQ(r.primitive(2).toWorld.matrices[0], Matrix());
}

TEST(Programs, AreRunWhereThatIsAllowed) {
  const std::string file = ::testing::TempDir() + "made_by_the_program";
  std::filesystem::remove(file);
  const std::string touch =
      "Procedural \"RunProgram\" [\"touch " + file + "\" \"\"] [0 1 0 1 0 1]\nSphere 2 -2 2 360";
  const Read without = readWorld(touch);
  expectMessage(without, "ASSET-PROGRAM-REFUSED", 2);
  EXPECT_EQ(without.world().primitives.size(), 2u) << "it is kept, for whoever writes the scene again";
  EXPECT_FALSE(std::filesystem::exists(file)) << "it was run all the same";
  ReadOptions allowed;
  allowed.allowExec = true;
  readWorld(touch, allowed);
  EXPECT_TRUE(std::filesystem::exists(file));
  std::filesystem::remove(file);

  // detail and data come to it, and after a byte 255 it is waited for no longer
  const std::string script = ::testing::TempDir() + "disk_maker";
  std::ofstream(script)
      << "#!/bin/sh\nread detail radius\necho Color 0 0 1\necho Disk 0 $radius 360\nprintf '\\377'\nsleep 1000\n";
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  const Read r = readWorld(
      "Color 1 0 0\nProcedural \"RunProgram\" [\"" + script + "\" \"2\"] [0 1 0 1 0 1]\nSphere 2 -2 2 360", allowed);
  ASSERT_EQ(r.world().primitives.size(), 2u) << r.all();
  const auto& disk = std::get<Quadric>(r.primitive(0).shape);
  EXPECT_EQ(disk.kind, Quadric::Kind::Disk);
  EXPECT_EQ(disk.args[1], 2);
  EXPECT_EQ((*r.primitive(1).attributes->color)[0], 1) << "attributes are as they were";
}

// The words of Procedural2 say what those of Procedural say; the 2 of the kind may be left out.
TEST(Programs, OfProcedural2AreRunByTheirParameters) {
  const std::string script = ::testing::TempDir() + "disk_maker_2";
  std::ofstream(script) << "#!/bin/sh\nread detail radius\necho Disk $1 $radius 360\n";
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  const std::string parameters = " \"string filename\" [\"" + script + " 7\"] \"string data\" [\"2\"]";
  ReadOptions allowed;
  allowed.allowExec = true;
  for (const char* kind : {"RunProgram2", "RunProgram"}) {
    const std::string request = "Procedural2 \"" + std::string(kind) + "\" \"SimpleBound\"" + parameters;
    for (const char* bound : {"", " \"float[6] bound\" [0 1 0 1 0 1]", " \"float[2] bound\" [0 1]"}) {
      const Read r = readWorld(request + bound, allowed);
      ASSERT_EQ(r.world().primitives.size(), 1u) << r.all();
      EXPECT_TRUE(r.messages.empty()) << r.all();
      const auto& disk = std::get<Quadric>(r.primitive(0).shape);
      EXPECT_EQ(disk.kind, Quadric::Kind::Disk);
      EXPECT_EQ(disk.args[0], 7);
      EXPECT_EQ(disk.args[1], 2);
    }
    expectMessage(readWorld(request), "ASSET-PROGRAM-REFUSED", 2);
  }
  const Read nameless = readWorld("Procedural2 \"RunProgram2\" \"SimpleBound\" \"string data\" [\"2\"]", allowed);
  EXPECT_EQ(nameless.count("RIB-ARGUMENTS"), 1u) << nameless.all();
}

// With a bound they wait for rays; which program, with which words, is a part of what the scene is known by.
TEST(Programs, OfProcedural2WaitWhereTheyHaveABound) {
  ReadOptions options;
  options.allowExec = options.delaysProcedurals = true;
  options.proceduralHost = "/nowhere/at/all";
  std::set<std::string> digests;
  const std::string bound = " \"float[6] bound\" [-1 1 -2 2 -3 3]";
  for (const std::string& request :
       {std::string("\"RunProgram2\" \"SimpleBound\" \"string filename\" [\"a\"] \"string data\" [\"1\"]"),
        std::string("\"RunProgram2\" \"SimpleBound\" \"string filename\" [\"a\"] \"string data\" [\"2\"]"),
        std::string("\"DynamicLoad2\" \"SimpleBound\" \"string dsoname\" [\"a\"] \"int seed\" [1]"),
        std::string("\"DynamicLoad2\" \"SimpleBound\" \"string dsoname\" [\"a\"] \"int seed\" [2]")}) {
    const Read r = readWorld("Procedural2 " + request + bound, options);
    EXPECT_TRUE(r.messages.empty()) << r.all();
    ASSERT_EQ(r.world().primitives.size(), 1u) << request;
    ASSERT_TRUE(boundOf(r.primitive(0))) << request;
    EXPECT_EQ(boundOf(r.primitive(0))->max, Imath::V3d(1, 2, 3));
    EXPECT_TRUE(digests.insert(ownDigestOf(r.primitive(0)).str()).second) << request;
  }
  // at once: there is no such object, and no such program
  for (const std::string& request :
       {"\"DynamicLoad2\" \"DSOBound\" \"string dsoname\" [\"a\"]" + bound,
        std::string("\"DynamicLoad2\" \"SimpleBound\" \"string dsoname\" [\"a\"]"),
        "\"RunProgram2\" \"SimpleBound\" \"string filename\" [\"/nowhere/at/all\"] \"int __immediatesubdivide\" [1]" +
            bound}) {
    const Read r = readWorld("Procedural2 " + request + "\nSphere 1 -1 1 360", options);
    EXPECT_EQ(r.count("ASSET-PROGRAM"), 1u) << request << r.all();
    EXPECT_EQ(r.world().primitives.size(), 1u) << request;
  }
}

// One message each, of a family that --strict counts, whether the kind is unknown or may not be run.
TEST(Procedurals, ThatAreLeftOutAreToldOnceAndCountAsAssets) {
  const std::pair<const char*, const char*> requests[] = {
      {"Procedural \"Foo\" [\"x\"] [-1 1 -1 1 -1 1]", "PLUGIN-PROCEDURAL"},
      {"Procedural2 \"Foo2\" \"SimpleBound\" \"string filename\" [\"x\"]", "PLUGIN-PROCEDURAL"},
      {"Procedural2 \"\" \"\"", "PLUGIN-PROCEDURAL"},
      {"Procedural \"RunProgram2\" [\"x\"] [-1 1 -1 1 -1 1]", "PLUGIN-PROCEDURAL"},
      {"Procedural \"RunProgram\" [\"x\"] [-1 1 -1 1 -1 1]", "ASSET-PROGRAM-REFUSED"},
      {"Procedural \"DynamicLoad\" [\"x\"] [-1 1 -1 1 -1 1]", "ASSET-PROGRAM-REFUSED"},
      {"Procedural2 \"RunProgram2\" \"SimpleBound\" \"string filename\" [\"x\"]", "ASSET-PROGRAM-REFUSED"},
      {"Procedural2 \"DynamicLoad2\" \"SimpleBound\" \"string dsoname\" [\"x\"]", "ASSET-PROGRAM-REFUSED"}};
  for (const auto& [request, code] : requests) {
    Diagnostics said([](const std::string&, Severity) {});
    RibReader reader(said, {}, [](scene::Scene&&) {});
    reader.readString("t.rib", "WorldBegin\n" + std::string(request) + "\nWorldEnd\n");
    EXPECT_EQ(said.assetProblems(), 1u) << request;
    ASSERT_EQ(said.messages().size(), 1u) << request;
    EXPECT_EQ(said.messages()[0].code, code) << request;
    EXPECT_EQ(said.messages()[0].pos.line, 2u) << request;
  }
}

TEST(Programs, ThatFailAreLeftOut) {
  ReadOptions allowed;
  allowed.allowExec = true;
  allowed.programSeconds = .5;
  for (const char* command : {"/nowhere/at/all", "false", "sleep 1000", "   ", "", "yes"}) {
    const auto start = std::chrono::steady_clock::now();
    const Read r = readWorld(
        "Procedural \"RunProgram\" [\"" + std::string(command) + "\" \"x\"] [0 1 0 1 0 1]\nSphere 2 -2 2 360",
        allowed);
    EXPECT_EQ(r.count("ASSET-PROGRAM"), 1u) << command << "\n" << r.all();
    EXPECT_EQ(r.world().primitives.size(), 1u) << command;
    EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 20) << command;
  }
  // garbage is what garbage in a file is; one that answers with itself is run once
  const Read garbage =
      readWorld("Procedural \"RunProgram\" [\"echo )(]\" \"x\"] [0 1 0 1 0 1]\nSphere 2 -2 2 360", allowed);
  EXPECT_FALSE(garbage.messages.empty());
  EXPECT_EQ(garbage.world().primitives.size(), 1u);
  allowed.programSeconds = 20;
  const std::string again =
      "Procedural \"RunProgram\" [\"cat " + ::testing::TempDir() + "again.rib\" \"x\"] [0 1 0 1 0 1]\n";
  std::ofstream(::testing::TempDir() + "again.rib") << again;
  const Read recursive = readWorld(again + "Sphere 2 -2 2 360", allowed);
  EXPECT_EQ(recursive.count("RIB-RECURSION"), 1u) << recursive.all();
}

}  // namespace
}  // namespace kinora::rib
