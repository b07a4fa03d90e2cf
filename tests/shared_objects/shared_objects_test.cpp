// Shared objects of Procedural "DynamicLoad": what they call arrives as the RIB of an archive, and what they do wrong
// stays in a process of their own.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include "procedurals/archives.h"
#include "rib/run_program.h"

namespace kinora::tests {
namespace {

std::string printed(const std::vector<std::string>& words) {
  std::string why;
  std::vector<std::string> command = {KINORA_PROCEDURAL};
  command.insert(command.end(), words.begin(), words.end());
  const auto text = rib::runProgram(command, "", {.seconds = 20}, why);
  EXPECT_TRUE(text) << why;
  return text.value_or("");
}
std::vector<std::string> linesOf(const std::string& text, const std::string& begin) {
  std::vector<std::string> found;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);)
    if (line.starts_with(begin)) found.push_back(line);
  return found;
}

struct World {
  std::optional<scene::Scene> scene;
  std::string said;
  size_t warnings = 0;
};
World read(const std::string& inside, rib::ReadOptions options = {}) {
  World out;
  Diagnostics diagnostics([&](const std::string& line, Severity s) {
    if (s == Severity::Info) return;
    out.said += line + "\n";
    ++out.warnings;
  });
  if (options.proceduralHost.empty()) options.proceduralHost = KINORA_PROCEDURAL;
  rib::RibReader reader(diagnostics, options, [&](scene::Scene&& s) { out.scene = std::move(s); });
  EXPECT_TRUE(reader.readString("test.rib", inside));
  reader.finish();
  return out;
}
std::string request(const std::string& object, const std::string& data) {
  return "Procedural \"DynamicLoad\" [\"" + object + "\" \"" + data + "\"] [-1 1 -1 1 -1 1]\n";
}
World run(const std::string& object, const std::string& data) {
  rib::ReadOptions options;
  options.allowExec = true;
  options.programSeconds = 10;
  return read("WorldBegin\n" + request(object, data) + "Disk 0 9 360\nWorldEnd\n", options);
}

TEST(SharedObjects, EveryFunctionPrintsARequestThatReads) {
  const std::string text = printed({OBJECT_every_request, ""});
  const World w = read(text);
  ASSERT_TRUE(w.scene) << text;
  // what is kept without effect is told; nothing is misread
  for (const char* code : {"RIB-SYNTAX", "RIB-ARGUMENTS", "RIB-UNKNOWN", "RIB-DECLARATION", "RIB-NESTING",
                           "RIB-RANGE", "RIB-OPTION-IN-WORLD", "RIB-OUTSIDE-WORLD", "GEOM-", "RIB-CONSISTENCY"})
    EXPECT_EQ(w.said.find(code), std::string::npos) << code << "\n" << w.said << "\n" << text;
  // each function that the header declares is exported, and each of those with a list is called here
  std::ifstream header(std::string(KINORA_SOURCE_DIR) + "/include/kinora/ri.h");
  std::set<std::string> requests;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) requests.insert(line.substr(0, line.find(' ')));
  size_t listed = 0;
  for (std::string line; std::getline(header, line);) {
    const size_t at = line.find(" Ri"), end = line.find('(');
    if (at == std::string::npos || end == std::string::npos || line.find(", ...);") == std::string::npos) continue;
    const std::string name = line.substr(at + 3, end - at - 3);
    if (name == "ArchiveRecord") continue;
    ++listed;
    EXPECT_TRUE(requests.contains(name)) << name;
  }
  EXPECT_GT(listed, 35u);
  EXPECT_EQ(w.scene->primitives.size(), 24u);
}

TEST(SharedObjects, ValuesAreAsManyAsTheShapeHas) {
  const std::string text = printed({OBJECT_behaviour, "counts"});
  const auto numbersIn = [](const std::string& line, const std::string& token) {
    size_t at = line.find("\"" + token + "\" [");
    EXPECT_NE(at, std::string::npos) << token << " in " << line;
    if (at == std::string::npos) return size_t(0);
    std::istringstream in(line.substr(at + token.size() + 4));
    size_t n = 0;
    for (double x; in >> x; ++n) EXPECT_EQ(x, double(n));
    return n;
  };
  const auto patch = linesOf(text, "PatchMesh");
  ASSERT_EQ(patch.size(), 1u);
  EXPECT_EQ(numbersIn(patch[0], "P"), 7u * 4 * 3);
  EXPECT_EQ(numbersIn(patch[0], "varying float v"), 3u * 2);
  EXPECT_EQ(numbersIn(patch[0], "uniform float[2] u"), 2u * 2);
  const auto curves = linesOf(text, "Curves");
  ASSERT_EQ(curves.size(), 2u);
  EXPECT_EQ(numbersIn(curves[0], "width"), 2u + 5) << "steps of 1";
  EXPECT_EQ(numbersIn(curves[1], "width"), 2u + 3) << "steps of 3, as before the block";
  EXPECT_EQ(numbersIn(curves[1], "P"), 11u * 3);
}

TEST(SharedObjects, AreRunWhereProgramsMayBe) {
  const World without = read("WorldBegin\n" + request(OBJECT_behaviour, "ball") + "WorldEnd\n");
  EXPECT_NE(without.said.find("ASSET-PROGRAM-REFUSED"), std::string::npos) << without.said;
  EXPECT_NE(without.said.find("--allow-exec"), std::string::npos) << without.said;
  const World with = run(OBJECT_behaviour, "ball");
  EXPECT_EQ(with.said, "");
  ASSERT_EQ(with.scene->primitives.size(), 2u) << "what the object prints to its user is no RIB";
  EXPECT_EQ((*with.scene->primitives[0]->attributes->color)[0], 1);
  EXPECT_FALSE(with.scene->primitives[1]->attributes->color) << "attributes are as they were";
}

TEST(SharedObjects, AreFoundWithoutTheirEndingAlongTheSearchPath) {
  const std::filesystem::path object = OBJECT_menger;
  const std::string folder = ::testing::TempDir() + "objects";
  std::filesystem::create_directories(folder);
  std::filesystem::copy_file(object, folder + "/sponge.so", std::filesystem::copy_options::overwrite_existing);
  rib::ReadOptions options;
  options.allowExec = true;
  const std::string sponge =
      "Option \"searchpath\" \"procedural\" [\"" + folder + "\"]\nWorldBegin\n" +
      request("sponge", "2 -1 1 -1 1 -1 1  1 1 1 1 0 1 1 1 1  1 0 1 0 0 0 1 0 1  1 1 1 1 0 1 1 1 1") + "WorldEnd\n";
  const World w = read(sponge, options);
  EXPECT_EQ(w.said, "");
  EXPECT_EQ(w.scene->primitives.size(), 400u);
  const World none = read("WorldBegin\n" + request("nowhere", "") + "Disk 0 1 360\nWorldEnd\n", options);
  EXPECT_NE(none.said.find("'nowhere' is not found"), std::string::npos) << none.said;
  EXPECT_EQ(none.scene->primitives.size(), 1u);
}

TEST(SharedObjects, ThatFailAreLeftOut) {
  for (const auto& [object, data] :
       std::vector<std::pair<const char*, const char*>>{{OBJECT_behaviour, "crash"},
                                                        {OBJECT_behaviour, "call what is not there"},
                                                        {OBJECT_behaviour, "exit"},
                                                        {OBJECT_no_entry, ""},
                                                        {KINORA_SOURCE_DIR "/README.md", ""}}) {
    const World w = run(object, data);
    EXPECT_NE(w.said.find("ASSET-PROGRAM"), std::string::npos) << data << "\n" << w.said;
    EXPECT_NE(w.said.find("test.rib:2"), std::string::npos) << w.said;
    EXPECT_EQ(w.said.find("longer than"), std::string::npos) << data << " was waited for\n" << w.said;
    EXPECT_EQ(w.warnings, 1u) << w.said;
    EXPECT_EQ(w.scene->primitives.size(), 1u) << data;
  }
  rib::ReadOptions options;
  options.allowExec = true;
  options.programSeconds = .5;
  const auto start = std::chrono::steady_clock::now();
  const World hung = read("WorldBegin\n" + request(OBJECT_behaviour, "hang") + "Disk 0 1 360\nWorldEnd\n", options);
  EXPECT_NE(hung.said.find("longer than"), std::string::npos) << hung.said;
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 20);
}

TEST(SharedObjects, ProceduralsInThemHaveTheirShareOfTheDetail) {
  const std::string text =
      printed({OBJECT_behaviour, "deeper", "--detail", "64", "--bound", "-1", "1", "-1", "1", "-1", "1"});
  const auto details = linesOf(text, "Attribute ");
  ASSERT_EQ(details.size(), 64u) << "as deep as they may be";
  EXPECT_NE(details[0].find("[64]"), std::string::npos) << details[0];
  EXPECT_NE(details[1].find("[16]"), std::string::npos) << details[1];
  EXPECT_NE(details[3].find("[1]"), std::string::npos) << details[3];
  EXPECT_EQ(linesOf(text, "AttributeBegin").size(), linesOf(text, "AttributeEnd").size());
}

TEST(SharedObjects, NameArchivesProgramsAndObjectsOfTheirOwn) {
  const std::string text = printed({OBJECT_behaviour, "archives"});
  EXPECT_EQ(linesOf(text, "Procedural \"DelayedReadArchive\" [\"inner.rib\"] [-1 1 -1 1 -1 1]").size(), 1u) << text;
  EXPECT_EQ(linesOf(text, "Procedural \"RunProgram\" [\"echo Sphere .2 -.2 .2 360\" \"data\"]").size(), 1u) << text;
  // two that each call their first object the same
  rib::ReadOptions options;
  options.allowExec = true;
  const World w = read("WorldBegin\n" + request(OBJECT_behaviour, "handles") +
                           request(OBJECT_behaviour, "handles again") + "WorldEnd\n",
                       options);
  EXPECT_EQ(w.said, "");
  ASSERT_EQ(w.scene->instances.size(), 2u);
  ASSERT_EQ(w.scene->prototypes.size(), 2u);
  EXPECT_NE(std::as_const(w.scene->instances).prototypeOf(0), std::as_const(w.scene->instances).prototypeOf(1));
}

TEST(SharedObjects, DeclareNamesForThemselves) {
  EXPECT_EQ(linesOf(printed({OBJECT_behaviour, "declared"}), "Sphere")[0], "Sphere 1 -1 1 360 \"mine\" [1 2 3 4]");
  EXPECT_EQ(linesOf(printed({OBJECT_behaviour, "undeclared"}), "Sphere")[0], "Sphere 1 -1 1 360");
}

// Procedural2: all parameters come to the object, with the types that the request says, also where Declare says them.
TEST(SharedObjects, OfProcedural2AreGivenTheirParameters) {
  rib::ReadOptions options;
  options.allowExec = true;
  options.programSeconds = 10;
  const auto requested = [](const std::string& object, const std::string& more) {
    return "Procedural2 \"DynamicLoad2\" \"SimpleBound\" \"float[6] bound\" [-1 1 -1 1 -1 1] \"string dsoname\" [\"" +
           object + "\"] " + more + "\n";
  };
  const std::string given =
      "\"seed\" [2] \"constant float[2] size\" [3 4.5] \"string[2] names\" [\"a\" \"b \\\"c\\\"\"]";
  const World w =
      read("Declare \"seed\" \"int\"\nWorldBegin\n" + requested(OBJECT_behaviour, given) + "WorldEnd\n", options);
  EXPECT_EQ(w.said, "");
  ASSERT_EQ(w.scene->primitives.size(), 2u);
  const auto& disk = std::get<scene::Quadric>(w.scene->primitives[1]->shape);
  EXPECT_EQ(disk.args[0], 3);
  EXPECT_EQ(disk.args[1], 4.5);
  EXPECT_EQ(w.scene->primitives[0]->attributes->named.getString("user:second", ""), "b \"c\"");
  EXPECT_EQ(w.scene->primitives[0]->attributes->named.getString("user:token", ""), "string[2] names");
  // one that knows Procedural alone has the text
  const std::string sponge = "2 -1 1 -1 1 -1 1  1 1 1 1 0 1 1 1 1  1 0 1 0 0 0 1 0 1  1 1 1 1 0 1 1 1 1";
  const World text =
      read("WorldBegin\n" + requested(OBJECT_menger, "\"string data\" [\"" + sponge + "\"]") + "WorldEnd\n", options);
  EXPECT_EQ(text.said, "");
  EXPECT_EQ(text.scene->primitives.size(), 400u);
  const World none = read("WorldBegin\n" + requested(OBJECT_no_entry, "") + "Disk 0 1 360\nWorldEnd\n", options);
  EXPECT_NE(none.said.find("ASSET-PROGRAM"), std::string::npos) << none.said;
  EXPECT_EQ(none.scene->primitives.size(), 1u);
  const World without = read("WorldBegin\n" + requested(OBJECT_behaviour, given) + "WorldEnd\n");
  EXPECT_NE(without.said.find("ASSET-PROGRAM-REFUSED"), std::string::npos) << without.said;
  EXPECT_NE(without.said.find("--allow-exec"), std::string::npos) << without.said;
}

// Through the whole renderer: met by a ray, run, drawn; the picture is that of the archive that it would print.
TEST(SharedObjects, AreRunOnceTheyAreMet) {
  const Folder folder(Files{{"ball.rib", "Color 1 0 0\nSphere .5 -.5 .5 360\n"}});
  const auto picture = [&](const std::string& what, bool runs) {
    std::ofstream(folder.file("scene.rib"))
        << kHead + "WorldBegin\n" + kLights + "Translate 0 0 5\n" + what + "WorldEnd\n";
    return rendered(folder, {}, runs, KINORA_PROCEDURAL);
  };
  const std::string bound = " [-.6 .6 -.6 .6 -.6 .6]\n";
  const Rendered archive =
      picture("Procedural \"DelayedReadArchive\" [\"" + folder.file("ball.rib") + "\"]" + bound, false);
  const Rendered object = picture("Procedural \"DynamicLoad\" [\"" OBJECT_behaviour "\" \"ball\"]" + bound, true);
  EXPECT_EQ(object.said, "");
  EXPECT_EQ(object.statistics.proceduralsRead, 1u);
  EXPECT_EQ(object.sums, archive.sums);
  const Rendered two = picture("Procedural2 \"DynamicLoad2\" \"SimpleBound\" \"float[6] bound\"" + bound +
                                   " \"string dsoname\" [\"" OBJECT_behaviour "\"] \"string what\" [\"ball\"]\n",
                               true);
  EXPECT_EQ(two.said, "");
  EXPECT_EQ(two.statistics.proceduralsRead, 1u);
  EXPECT_EQ(two.sums, archive.sums);
  EXPECT_NE(archive.sums, picture("", false).sums);
}

}  // namespace
}  // namespace kinora::tests
