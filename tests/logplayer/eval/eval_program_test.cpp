// Runs the built program as a person would: what it prints, writes and returns.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/recordings.hpp"

namespace fusion_slam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

struct RunOutcome {
  int exit_code = -1;
  std::string output;  // stdout and stderr
};

RunOutcome eval(const std::string& arguments) {
  const std::string command = std::string(FS_BINARY_DIR) + "/bin/eval " + arguments + " 2>&1";
  RunOutcome run;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return run;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) run.output += static_cast<char>(c);
  const int status = pclose(pipe);
  if (WIFEXITED(status)) run.exit_code = WEXITSTATUS(status);
  return run;
}

class EvalProgram : public ::testing::Test {
 protected:
  EvalProgram() {
    folder_ = std::filesystem::temp_directory_path() / ("eval_test_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    // A square of 1 m driven in 40 s, once true and once 10 cm off to the side and 30 s short.
    write(
        "ref.tum", [](int i) { return i < 400; }, 0.0);
    write(
        "est.tum", [](int i) { return i < 101; }, 0.1);
    write(
        "line.tum", [](int i) { return i < 90; }, 0.0);
    std::ofstream(path("lab.relations")) << "100.0 101.0 0.1 0 0 0 0 0\n102.0 104.0 0.2 0 0 0 0 0\n"
                                         << "900.0 901.0 0 0 0 0 0 0\n";
    std::ofstream(path("garbled.tum")) << "# fine so far\n1 2 3 4 0 0 0 1\n2 2 3 4 0 0 oops 1\n";
    std::ofstream(path("empty.tum")) << "";
  }
  ~EvalProgram() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string both() const { return path("ref.tum") + " " + path("est.tum"); }

  template <typename Keep>
  void write(const std::string& name, Keep keep, double offset_y_m) const {
    std::ofstream out(path(name));
    for (int i = 0; i < 400 && keep(i); ++i) {
      const double along = (i % 100) * 0.01;
      const double x = i < 100 ? along : i < 200 ? 1.0 : i < 300 ? 1.0 - along : 0.0;
      const double y = i < 100 ? 0.0 : i < 200 ? along : i < 300 ? 1.0 : 1.0 - along;
      out << 100.0 + 0.1 * i << ' ' << x << ' ' << y + offset_y_m << " 0 0 0 0 1\n";
    }
  }

  nlohmann::json read_json(const std::string& name) const {
    std::ifstream in(path(name));
    return nlohmann::json::parse(in);
  }

  std::filesystem::path folder_;
};

TEST_F(EvalProgram, Helps) {
  for (const char* arguments : {"--help", "ape --help", "rpe --help", "relations --help"}) {
    const RunOutcome run = eval(arguments);
    EXPECT_EQ(run.exit_code, 0) << arguments;
    EXPECT_THAT(run.output, HasSubstr("Usage: eval"));
  }
}

TEST_F(EvalProgram, ReturnsTwoForWrongUsage) {
  for (const std::string& arguments :
       {std::string(), std::string("ape"), std::string("score a b"),
        "ape " + both() + " --align yes", "ape " + both() + " --unit m",
        "rpe " + both() + " --delta 0", "ape " + both() + " --max-diff nan",
        "ape " + both() + " --window 5 1", "relations " + both() + " --align se3"}) {
    const RunOutcome run = eval(arguments);
    EXPECT_EQ(run.exit_code, 2) << arguments;
    EXPECT_THAT(run.output, HasSubstr("--help")) << arguments;
  }
}

TEST_F(EvalProgram, ReturnsOneAndTheReasonWhenNothingCanBeComputed) {
  const auto problem = [](const std::string& arguments) {
    const RunOutcome run = eval(arguments);
    EXPECT_EQ(run.exit_code, 1) << arguments;
    EXPECT_THAT(run.output, StartsWith("eval: "));
    return run.output;
  };
  const std::string ref = path("ref.tum") + " ";
  EXPECT_THAT(problem("ape " + ref + "/nowhere.tum"), HasSubstr("/nowhere.tum: no such file"));
  EXPECT_THAT(problem("ape " + ref + path("empty.tum")),
              HasSubstr("empty.tum: no line of numbers"));
  EXPECT_THAT(problem("ape " + ref + path("garbled.tum")),
              AllOf(HasSubstr("garbled.tum:3: field 7"), HasSubstr("'oops'")));
  EXPECT_THAT(problem("ape " + ref + path("line.tum") + " --align se3"), HasSubstr("on one line"));
  EXPECT_THAT(problem("rpe " + both() + " --delta 50 --unit m"), HasSubstr("smaller --delta"));
  EXPECT_THAT(
      problem("relations " + path("lab.relations") + " " + path("ref.tum") + " --time-offset 5000"),
      HasSubstr("--time-offset"));
  EXPECT_THAT(problem("ape " + both() + " --json /nowhere/a.json"), HasSubstr("can't be written"));
  EXPECT_THAT(problem("ape " + both() + " --plot /nowhere/a.png"), HasSubstr("can't be written"));
}

TEST_F(EvalProgram, PrintsErrorAndCoverage) {
  const RunOutcome run = eval("ape " + both());
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.output, AllOf(HasSubstr("rmse       0.100000"), HasSubstr("coverage   25.06 %"),
                                HasSubstr("use --align se3")));
}

TEST_F(EvalProgram, WritesJsonAndPlot) {
  const RunOutcome run = eval("rpe " + both() + " --delta 5 --all-pairs --relation full --json " +
                              path("out.json") + " --plot " + path("out.png"));
  EXPECT_EQ(run.exit_code, 0) << run.output;
  const nlohmann::json json = read_json("out.json");
  EXPECT_EQ(json.at("metric"), "rpe");
  EXPECT_EQ(json.at("relation"), "full");
  EXPECT_EQ(json.at("compared"), 96);
  EXPECT_NEAR(json.at("statistics").at("max").get<double>(), 0.0, 1e-12);
  EXPECT_NEAR(json.at("coverage_percent").get<double>(), 25.06, 0.01);
  EXPECT_GT(std::filesystem::file_size(path("out.png")), 10000u);
}

TEST_F(EvalProgram, WritesAPageForPeople) {
  const auto page_of = [&](const std::string& arguments) {
    const RunOutcome run = eval(arguments + " --report " + path("report.html"));
    EXPECT_EQ(run.exit_code, 0) << run.output;
    std::ifstream in(path("report.html"));
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  std::string page = page_of("ape " + both());
  EXPECT_THAT(page, AllOf(StartsWith("<!doctype html>"), HasSubstr("Absolute pose error"),
                          HasSubstr("<h2>Map</h2>"), HasSubstr("Coverage"), HasSubstr("<svg")));
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_EQ(page.find("http"), page.find("http://www.w3.org"));  // nothing is fetched
  page = page_of("rpe " + both() + " --relation rotation");
  EXPECT_THAT(page, AllOf(HasSubstr("Relative pose error"), HasSubstr("error, deg")));
  page = page_of("relations " + path("lab.relations") + " " + path("ref.tum"));
  EXPECT_THAT(page, HasSubstr("<pre>"));
}

TEST_F(EvalProgram, Relations) {
  const RunOutcome run = eval("relations " + path("lab.relations") + " " + path("ref.tum") +
                              " --json " + path("out.json"));
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_THAT(run.output, HasSubstr("2 of 3 relations usable (66.67 %)"));
  const nlohmann::json json = read_json("out.json");
  EXPECT_EQ(json.at("usable"), 2);
  EXPECT_EQ(json.at("total"), 3);
  EXPECT_NEAR(json.at("translation_m").at("mean").get<double>(), 0.0, 1e-9);
}

TEST_F(EvalProgram, EqualsEvoOnRealTrajectories) {
  FS_RECORDING(trajectories, "trajectories");
  const std::string files = (trajectories / "freiburg1_xyz-groundtruth.txt").string() + " " +
                            (trajectories / "freiburg1_xyz-rgbdslam.txt").string();
  const RunOutcome run = eval("ape " + files + " --align se3 --json " + path("out.json"));
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_NEAR(read_json("out.json").at("statistics").at("rmse").get<double>(), 0.013470088849733684,
              1e-11);
}

TEST_F(EvalProgram, MapAgainstItselfMovedIsPerfectAfterAlignment) {
  const std::string cells =
      std::string(4, '\0') + std::string("\0\xFE\xFE\0", 4) + std::string(4, '\0');
  std::ofstream(path("map.pgm"), std::ios::binary) << "P5\n4 3\n255\n" << cells;
  std::ofstream(path("ref.yaml")) << "image: map.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n";
  std::ofstream(path("est.yaml")) << "image: map.pgm\nresolution: 0.1\norigin: [0, 0.1, 0]\n";
  std::ofstream(path("classes.pgm"), std::ios::binary)
      << "P5\n4 3\n255\n"
      << std::string("\1\1\1\1\3\0\0\1\1\1\1\1", 12);
  const std::string maps = "map " + path("ref.yaml") + " " + path("est.yaml");
  const RunOutcome aligned =
      eval(maps + " --align " + both() + " --tolerance-cells 0 --classes " + path("classes.pgm") +
           " --json " + path("map.json") + " --plot " + path("map.png"));
  EXPECT_EQ(aligned.exit_code, 0) << aligned.output;
  EXPECT_THAT(aligned.output, AllOf(HasSubstr("recall           100.00 %   (10 of 10"),
                                    HasSubstr("chair               1     100.00 %")));
  const auto json = read_json("map.json");
  EXPECT_EQ(json["precision"], 1.0);
  EXPECT_EQ(json["by_class"]["wall"]["cells"], 9);
  EXPECT_NEAR(json["alignment"]["y_m"].get<double>(), -0.1, 1e-6);
  EXPECT_GT(std::filesystem::file_size(path("map.png")), 1000U);

  const RunOutcome as_it_is = eval(maps + " --tolerance-cells 0");
  EXPECT_EQ(as_it_is.exit_code, 0) << as_it_is.output;
  EXPECT_THAT(as_it_is.output, AllOf(HasSubstr("use --align"), HasSubstr("(4 of 10 in the")));
}

TEST_F(EvalProgram, MapProblemsAreNamed) {
  EXPECT_EQ(eval("map " + path("none.yaml") + " " + path("none.yaml")).exit_code, 1);
  EXPECT_THAT(eval("map " + path("none.yaml") + " " + path("none.yaml")).output,
              HasSubstr("none.yaml: can't be read"));
  EXPECT_EQ(eval("map " + path("none.yaml")).exit_code, 2);
}

}  // namespace
}  // namespace fusion_slam
