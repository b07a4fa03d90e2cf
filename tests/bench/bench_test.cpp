// Proves that kinora-bench runs every group on tiny sizes and writes flat JSON with all promised keys, each with its
// spread; and that its scalar twin of PxrSurface still has the material's formulas. It says nothing of the figures.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <sys/wait.h>

namespace {

struct Result {
  int code = -1;
  std::string out;
};
Result run(const std::string& arguments) {
  Result r;
  FILE* p = popen((std::string(KINORA_BENCH " ") + arguments + " 2>&1").c_str(), "r");
  if (!p) return r;
  char part[4096];
  for (size_t n; (n = std::fread(part, 1, sizeof part, p)) > 0;) r.out.append(part, n);
  const int status = pclose(p);
  r.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return r;
}

TEST(Bench, ListSaysWhatEachFamilyMeasures) {
  const Result r = run("list");
  EXPECT_EQ(r.code, 0) << r.out;
  for (const char* word : {"core", "trace_vs_embree", "surface_width_gain", "threads_2", "texture_vs_oiio",
                           "bytes_per_triangle", "lane_use_first_hit", "lookups_vs_openvdb", "match_orders"})
    EXPECT_NE(r.out.find(word), std::string::npos) << word;
}

TEST(Bench, UnknownNamesAreRefused) {
  EXPECT_EQ(run("nothing").code, 2);
  EXPECT_EQ(run("core --quick --only nothing").code, 2);
  EXPECT_EQ(run("core --quick --repeat 0").code, 2);
  EXPECT_EQ(run("").code, 2);
}

TEST(Bench, AnUnwritableFileIsSaid) {
  const Result r = run("core --quick --repeat 1 --only lanes --json /proc/none/bench.json");
  EXPECT_EQ(r.code, 6) << r.out;
  EXPECT_NE(r.out.find("BENCH-WRITE"), std::string::npos) << r.out;
}

// Something is found to be wrong, and said in these words.
void expectFails(const std::string& arguments, const std::string& words) {
  const Result r = run(arguments);
  EXPECT_EQ(r.code, 1) << r.out;
  EXPECT_NE(r.out.find(words), std::string::npos) << r.out;
}

// The figures that a run writes, which finds nothing wrong: rays counted, rays replayed and hits agree.
nlohmann::json written(const std::string& arguments) {
  std::string folder = (std::filesystem::temp_directory_path() / "kinora-bench-test-XXXXXX").string();
  if (!mkdtemp(folder.data())) return {};
  const Result r = run(arguments + " --json " + folder + "/figures.json");
  EXPECT_EQ(r.code, 0) << r.out;
  EXPECT_EQ(r.out.find("BENCH-"), std::string::npos) << r.out;
  std::ifstream file(folder + "/figures.json");
  nlohmann::json j = nlohmann::json::parse(file, nullptr, false);
  std::filesystem::remove_all(folder);
  EXPECT_TRUE(j.is_object()) << r.out;
  return j;
}

TEST(Bench, CoreWritesFlatJsonWithEveryKey) {
  const nlohmann::json j = written("core --quick --repeat 2");
  ASSERT_TRUE(j.is_object());
  for (const auto& [name, value] : j.items()) EXPECT_TRUE(value.is_number()) << name;
  for (const char* name : {"curves_vs_embree",
                           "trace_vs_embree_10k",
                           "trace_vs_embree_1m",
                           "frame_vs_embree_10k",
                           "frame_vs_embree_1m",
                           "rays_per_sample_10k",
                           "rays_per_sample_1m",
                           "surface_width_gain",
                           "width1_vs_scalar",
                           "frame_width_gain",
                           "frame_width_gain_textures",
                           "texture_vs_oiio",
                           "threads_2",
                           "bytes_per_triangle",
                           "lane_use_first_hit",
                           "first_pixel_seconds",
                           "ns_shading_10k",
                           "ns_film_1m",
                           "ns_above_embree_10k",
                           "ns_above_embree_1m",
                           "ns_above_embree_rich",
                           "ns_outside_trace_rich",
                           "trace_vs_embree_rich",
                           "ns_lights_rich",
                           "lane_use_depth0_rich",
                           "lane_use_depth4_rich",
                           "points_per_group_depth1_rich",
                           "lane_use_queries_rich"}) {
    ASSERT_TRUE(j.contains(name)) << name;
    ASSERT_TRUE(j.contains(std::string(name) + "_min") && j.contains(std::string(name) + "_max")) << name;
    EXPECT_GT(j[name].get<double>(), 0) << name;
    EXPECT_LE(j[std::string(name) + "_min"].get<double>(), j[name].get<double>()) << name;
    EXPECT_GE(j[std::string(name) + "_max"].get<double>(), j[name].get<double>()) << name;
  }
  EXPECT_FALSE(j.contains("time_growth_1e4_1e6"));
  // a difference of two times: at sizes this small it may be below 0
  EXPECT_TRUE(j.contains("lpe_cost_12"));
  EXPECT_LT(j["scalar_difference"].get<double>(), 1e-4) << "bench/scalar_surface.cpp has fallen behind PxrSurface";
}

TEST(Bench, ScenesAreWrittenForThePrograms) {
  std::string folder = (std::filesystem::temp_directory_path() / "kinora-bench-test-XXXXXX").string();
  ASSERT_TRUE(mkdtemp(folder.data()));
  const Result r = run("scenes --quick --out " + folder + "/scenes");
  EXPECT_EQ(r.code, 0) << r.out;
  EXPECT_EQ(r.out, folder + "/scenes/rich.rib\n" + folder + "/scenes/glass.rib\n");
  size_t textures = 0;
  for (const auto& f : std::filesystem::directory_iterator(folder + "/scenes"))
    textures += f.path().extension() == ".tx";
  EXPECT_EQ(textures, 200u);  // 40 materials of five
  std::filesystem::remove_all(folder);
  EXPECT_EQ(run("scenes").code, 2);
  const Result unwritable = run("scenes --quick --out /proc/none");
  EXPECT_EQ(unwritable.code, 6) << unwritable.out;
  EXPECT_NE(unwritable.out.find("BENCH-WRITE"), std::string::npos) << unwritable.out;
}

// The machine's programs and the fused ones give the same bits, and a single value that differs ends with 1.
TEST(Bench, AValueOfTheMachineThatDiffersFails) {
  const Result sound = run("shading --quick --repeat 1 --only machine");
  EXPECT_EQ(sound.code, 0) << sound.out;
  EXPECT_EQ(sound.out.find("BENCH-VALUES"), std::string::npos) << sound.out;
  EXPECT_EQ(sound.out.find("warning"), std::string::npos) << sound.out;  // as of a picture that is not there
  // the figure says which programs it is the median of
  EXPECT_NE(sound.out.find("of marble, "), std::string::npos) << sound.out;
  expectFails("shading --quick --repeat 1 --only machine --spoil", "BENCH-VALUES: marble: 1 of 3072 values");
}

TEST(Bench, SamplingWritesErrorsByIntegrandAndCount) {
  const nlohmann::json j = written("sampling --quick");
  ASSERT_TRUE(j.is_object());
  for (const char* sequence : {"independent", "pmj02", "sobol", "matched"}) {
    const std::string name = std::string("error_") + sequence + "_penumbra_across_4d_16";
    ASSERT_TRUE(j.contains(name)) << name;
    EXPECT_GT(j[name].get<double>(), 0) << name;
  }
  EXPECT_LT(j["error_matched_slope_2d_16"].get<double>(), 0.5 * j["error_independent_slope_2d_16"].get<double>());
  EXPECT_TRUE(j.contains("screen_morton_1_averaged"));
}

// What stands in the source is what the search finds.
TEST(Bench, MatchedOrdersAreThoseOfTheSource) {
  const Result r = run("match_orders");
  EXPECT_EQ(r.code, 0) << r.out;
}

TEST(Bench, EditsWriteFlatJsonWithEveryKey) {
  const nlohmann::json j = written("edits --quick --repeat 2");
  ASSERT_TRUE(j.is_object());
  for (const char* kind : {"camera", "light", "dome", "material", "object"})
    for (const char* measure : {"_ms", "_cpu_ms"}) {
      const std::string name = std::string("edit_") + kind + measure;
      ASSERT_TRUE(j.contains(name)) << name;
      EXPECT_GT(j[name].get<double>(), 0) << name;
    }
  EXPECT_GT(j["edit_load_ms"].get<double>(), 0);
}

TEST(Bench, MediaWriteFlatJsonWithEveryKey) {
  const nlohmann::json j = written("media --quick --repeat 2");
  ASSERT_TRUE(j.is_object());
  for (const char* name : {"fog_vs_clear", "lookups_vs_openvdb_along_rays", "lookups_vs_openvdb_anywhere",
                           "ns_cloud_collision_8", "ns_cloud_collision_256", "cloud_growth_256", "cloud_lane_use",
                           "walks_vs_diffuse_0.1", "walks_vs_diffuse_1", "profile_vs_diffuse_0.3"}) {
    ASSERT_TRUE(j.contains(name)) << name;
    EXPECT_GT(j[name].get<double>(), 0) << name;
  }
  // a lookup that is not OpenVDB's is found
  expectFails("media --quick --repeat 1 --only lookups --spoil", "BENCH-VALUES: lookups differ");
}

TEST(Bench, FramesOfShadersAreThoseOfPlugIns) {
  const Result r = run("shading --quick --repeat 1 --only frames");
  EXPECT_EQ(r.code, 0) << r.out;
  EXPECT_NE(r.out.find("frame_vs_patterns"), std::string::npos) << r.out;
  // only their noise differs
  double shaders = 0, plugins = 0;
  const size_t at = r.out.find("mean of the frames: ");
  ASSERT_NE(at, std::string::npos) << r.out;
  ASSERT_EQ(std::sscanf(r.out.c_str() + at, "mean of the frames: %lf by shaders, %lf", &shaders, &plugins), 2);
  EXPECT_NEAR(shaders / plugins, 1, 0.15);
}

}  // namespace
