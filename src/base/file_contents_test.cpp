// What a file holds decides its digest, not its name, place or time; a world forgets the files of the one before.
#include "base/file_contents.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace kinora {
namespace {

namespace fs = std::filesystem;

class Files : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("kinora-contents-" + std::to_string(getpid()));
    fs::create_directories(folder_ / "other");
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string put(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return (folder_ / name).string();
  }
  fs::path folder_;
};

TEST_F(Files, ContentDecides) {
  const std::string a = put("a", "some bytes"), b = put("other/b", "some bytes"), c = put("c", "some bytez");
  EXPECT_EQ(digestOfFile(a), digestOfFile(b));
  EXPECT_NE(digestOfFile(a), digestOfFile(c));
  EXPECT_FALSE(digestOfFile((folder_ / "none").string()));
  EXPECT_FALSE(digestOfFile(folder_.string())) << "a folder";
  fs::last_write_time(a, fs::file_time_type::clock::now() - std::chrono::hours(9));
  EXPECT_EQ(digestOfFile(a), digestOfFile(b)) << "a copy has another time";
}

// Every byte of a file up to the bound, and of a larger one its size, its ends and every 1,024th part.
TEST_F(Files, LargeOnes) {
  std::string bytes(kWholeFile, 'x');
  const std::string file = put("large", bytes);
  const auto whole = digestOfFile(file);
  for (const size_t at : {size_t(0), size_t(5'000'001), bytes.size() - 1}) {
    std::string other = bytes;
    other[at] = 'y';
    put("large", other);
    EXPECT_NE(digestOfFile(file), whole) << at;
  }
  bytes += std::string(8 << 20, 'x');
  put("large", bytes);
  const auto sampled = digestOfFile(file);
  EXPECT_NE(sampled, whole);
  put("large", bytes + "x");
  EXPECT_NE(digestOfFile(file), sampled);
  const size_t run = bytes.size() / 1024 + 1;
  for (const size_t at : {size_t(0), size_t(1'048'570), size_t(7'654'321), bytes.size() - run}) {
    std::string other = bytes;
    other.replace(at, run, run, 'y');
    put("large", other);
    EXPECT_NE(digestOfFile(file), sampled) << at;
  }
}

TEST_F(Files, AWorldHasItsOwn) {
  const std::string a = put("a", "1"), b = put("b", "2");
  FileContents contents;
  contents.use("texture", "a", std::vector{a});
  contents.use("texture", "gone", std::vector<std::string>());
  contents.use("shader", "s", digestOf("code"));
  const auto first = contents.used();
  ASSERT_EQ(first.size(), 3u);
  EXPECT_EQ(first[0].name, "s");
  EXPECT_EQ(first[1].content, digestOfFile(a));
  EXPECT_FALSE(first[2].content);
  // what was read stays what it was: who asked for it holds the old content as well
  put("a", "3");
  EXPECT_EQ(contents.used(), first);
  contents.begin();
  EXPECT_TRUE(contents.used().empty());
  contents.again("texture", "a");
  contents.again("texture", "never");
  contents.use("texture", "b", {a, b});
  const auto second = contents.used();
  ASSERT_EQ(second.size(), 2u);
  EXPECT_EQ(second[0], first[1]);
  // changed between its use and the reading: it is like no other file
  const std::string late = put("late", "1");
  contents.use("volume", "late", {late});
  fs::last_write_time(late, fs::file_time_type::clock::now() - std::chrono::hours(1));
  EXPECT_NE(contents.contentOf("volume", "late"), digestOfFile(late));
  EXPECT_NE(contents.contentOf("volume", "late"), std::nullopt);
  EXPECT_EQ(contents.contentOf("volume", "never"), std::nullopt);
  const auto atlas = second[1].content;
  contents.use("texture", "b", std::vector{b});
  EXPECT_NE(contents.contentOf("texture", "b"), atlas);
}

// Who keeps what was made of files says their names again in another world, and learns when they have changed.
TEST_F(Files, OfWhatIsKept) {
  const std::string a = put("a", "one"), b = put("b", "two");
  FileContents contents;
  FileContents::Names names;
  {
    const FileContents::Listening listening(contents, names);
    contents.use("texture", "a", std::vector{a});
    contents.use("texture", "none", std::vector<std::string>());
  }
  contents.use("texture", "b", std::vector{b});
  EXPECT_EQ(names, (FileContents::Names{{"texture", "a"}, {"texture", "none"}}));
  contents.begin();
  EXPECT_TRUE(contents.names().empty());
  contents.again(names);
  ASSERT_EQ(contents.names().size(), 2u);
  EXPECT_EQ(contents.names()[0].name, "a");

  std::vector<std::string> asked;
  std::string place;
  const auto find = [&](const FileContents::Entry& e) {
    asked.push_back(e.name);
    return place;
  };
  EXPECT_FALSE(contents.hasChanged(find));
  EXPECT_EQ(asked, std::vector<std::string>{"none"});
  place = "somewhere";
  EXPECT_TRUE(contents.hasChanged(find));
  place.clear();
  put("b", "three");  // not used in this world, and read before
  EXPECT_TRUE(contents.hasChanged(find));
  contents.forgetAll();
  EXPECT_FALSE(contents.hasChanged(find));
}

}  // namespace
}  // namespace kinora
