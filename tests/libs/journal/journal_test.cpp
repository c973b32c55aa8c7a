#include "libs/journal/journal.hpp"

#include <csignal>
#include <fstream>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class JournalTest : public testing::Test {
 protected:
  void SetUp() override { fs::remove(file_); }
  void TearDown() override { fs::remove(file_); }

  static std::vector<std::uint8_t> bytes_of(int i) {
    std::mt19937 rng(static_cast<unsigned>(i));
    std::vector<std::uint8_t> bytes(20 + rng() % 60);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(rng());
    return bytes;
  }
  void write(int n) {
    Journal journal(file_);
    for (int i = 0; i < n; ++i) {
      const auto bytes = bytes_of(i);
      ASSERT_TRUE(journal.append(1000 + i, "KEYFRAME", bytes.data(), bytes.size()));
    }
    EXPECT_TRUE(journal.sync());
  }
  // How many records are read, each checked.
  int read() {
    int n = 0;
    read_journal(file_, [&](const LogEvent& event) {
      EXPECT_EQ(event.data, bytes_of(n));
      EXPECT_EQ(event.timestamp_us, 1000 + n);
      EXPECT_EQ(event.channel, "KEYFRAME");
      ++n;
    });
    return n;
  }
  std::string content() const {
    std::ifstream in(file_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void set_content(const std::string& text) const {
    std::ofstream(file_, std::ios::binary) << text;
  }

  fs::path file_ =
      fs::path(testing::TempDir()) / ("journal_test_" + std::to_string(getpid()) + ".lcmlog");
};

TEST_F(JournalTest, AMessageWithoutBytesIsARecordToo) {
  {
    Journal journal(file_);
    EXPECT_TRUE(journal.append(1, "EMPTY", nullptr, 0));
    const std::uint8_t byte = 7;
    EXPECT_TRUE(journal.append(2, "EMPTY", &byte, 0));
    EXPECT_TRUE(journal.append(3, "ONE", &byte, 1));
  }
  const JournalState state = read_journal(file_, {});
  EXPECT_EQ(state.n_records, 3);
  EXPECT_EQ(state.cut_bytes, 0);
}

TEST_F(JournalTest, GivesBackWhatWasWritten) {
  EXPECT_EQ(read(), 0) << "no file";
  write(20);
  EXPECT_EQ(read(), 20);
}

// A power cut at each byte of the last record: the others are whole, and writing goes on.
TEST_F(JournalTest, SurvivesBeingCutAtEveryByte) {
  write(3);
  const std::string two = content().substr(0, content().size() - bytes_of(2).size() - 8 - 28);
  const std::string all = content();
  for (std::size_t size = two.size(); size < all.size(); ++size) {
    set_content(all.substr(0, size));
    EXPECT_EQ(read(), 2) << size;
    {
      Journal journal(file_);
      EXPECT_EQ(journal.state().n_records, 2);
      EXPECT_EQ(journal.state().cut_bytes, static_cast<std::int64_t>(size - two.size()));
      const auto bytes = bytes_of(2);
      ASSERT_TRUE(journal.append(1002, "KEYFRAME", bytes.data(), bytes.size()));
    }
    EXPECT_EQ(content(), all) << size;
  }
  for (std::size_t size = 0; size < 40; ++size) {  // of the first record
    set_content(all.substr(0, size));
    EXPECT_EQ(read(), 0) << size;
    EXPECT_EQ(Journal(file_).state().n_records, 0) << size;
  }
}

TEST_F(JournalTest, EveryDamagedBitIsFound) {
  write(3);
  const std::string all = content();
  const std::size_t last = all.size() - bytes_of(2).size() - 8 - 28;
  for (std::size_t bit = 8 * last; bit < 8 * all.size(); ++bit) {
    std::string damaged = all;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    set_content(damaged);
    EXPECT_EQ(read(), 2) << bit;
  }
}

TEST_F(JournalTest, RecordsOfOneAreNotTakenForThoseOfAnother) {
  write(3);
  std::string all = content();
  const std::size_t first = bytes_of(0).size() + 8 + 28;
  set_content(all.substr(first));  // begins with the second record
  EXPECT_EQ(read(), 0);
}

TEST_F(JournalTest, HasOneWriter) {
  Journal journal(file_);
  try {
    Journal second(file_);
    FAIL() << "two writers";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("run twice"));
  }
}

TEST_F(JournalTest, LeavesForeignFilesAlone) {
  set_content("a letter that is no journal, and long enough to be one");
  EXPECT_THROW(Journal journal(file_), std::runtime_error);
  EXPECT_THAT(content(), HasSubstr("a letter"));
  EXPECT_THROW(Journal("/nowhere/x.lcmlog"), std::runtime_error);
}

TEST_F(JournalTest, AFullDiskIsSaidAndHurtsNothing) {
  write(2);
  // The file's own size is limited instead of the disk's.
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{200, 200};
    setrlimit(RLIMIT_FSIZE, &limit);
    Journal journal(file_);
    const std::vector<std::uint8_t> large(1000, 1);
    _exit(journal.append(1, "KEYFRAME", large.data(), large.size()) ? 1 : 0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(read(), 2);
}

TEST_F(JournalTest, WrittenAnewItHoldsWhatWasKeptAndWhatCameMeanwhile) {
  write(6);
  const fs::path anew = file_.string() + ".new";
  {
    Journal journal(file_);
    const auto append = [&](int i) {
      const auto bytes = bytes_of(i);
      ASSERT_TRUE(journal.append(1000 + i, "KEYFRAME", bytes.data(), bytes.size()));
    };
    std::int64_t offset_bytes = 0;
    read_journal(file_, [&](const LogEvent& event) {
      if (event.data == bytes_of(4)) offset_bytes = event.offset_bytes;
    });
    const auto kept = journal.record_at(offset_bytes, 4);
    ASSERT_TRUE(kept);
    EXPECT_EQ(kept->data, bytes_of(4));
    EXPECT_FALSE(journal.record_at(offset_bytes, 3)) << "of another number";
    EXPECT_FALSE(journal.record_at(offset_bytes + 1, 4));
    EXPECT_FALSE(journal.record_at(1 << 30, 4));
    ASSERT_TRUE(journal.begin_anew());
    EXPECT_FALSE(journal.begin_anew()) << "one at a time";
    ASSERT_TRUE(journal.append_anew(kept->timestamp_us, kept->channel, kept->data.data(),
                                    kept->data.size()));
    append(6);
    EXPECT_EQ(read(), 7) << "killed now, the old one is whole";
    ASSERT_TRUE(journal.finish_anew());
    append(7);
    EXPECT_THROW(Journal{file_}, std::runtime_error) << "still one process";
  }
  EXPECT_FALSE(fs::exists(anew));
  std::vector<std::vector<std::uint8_t>> left;
  const JournalState state =
      read_journal(file_, [&](const LogEvent& event) { left.push_back(event.data); });
  EXPECT_EQ(state.cut_bytes, 0);
  EXPECT_THAT(left, testing::ElementsAre(bytes_of(4), bytes_of(6), bytes_of(7)));
}

TEST_F(JournalTest, KilledWhileItIsWrittenAnewTheOldOneGoesOn) {
  write(5);
  const fs::path anew = file_.string() + ".new";
  const pid_t child = fork();
  if (child == 0) {
    Journal journal(file_);
    const auto bytes = bytes_of(5);
    const bool ok = journal.begin_anew() &&
                    journal.append_anew(1, "KEYFRAME", bytes.data(), bytes.size()) &&
                    journal.append(1005, "KEYFRAME", bytes.data(), bytes.size());
    if (!ok) _exit(1);
    raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_TRUE(fs::exists(anew));
  EXPECT_EQ(read(), 6);
  { EXPECT_EQ(Journal(file_).state().n_records, 6); }
  EXPECT_FALSE(fs::exists(anew)) << "left over: removed";
}

}  // namespace
}  // namespace fusion_slam
