// A command's `exec` text, split as a shell splits simple commands. No shell is ever run.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace fusion_slam {

struct ExecLine {
  std::vector<std::pair<std::string, std::string>> environment;  // NAME=VALUE before the program
  std::vector<std::string> argv;                                 // the program and its arguments
};

// Value of a variable of the environment; nothing when it has none.
using Environment = std::function<std::optional<std::string>(const std::string& name)>;

// Blanks split, 'quotes' and "quotes" join, \ takes the next character as it is. $NAME and ${NAME},
// not within '...', become a NAME=VALUE given before in the same text, else the environment's
// value, else stay as they are (for a shell that is run, as with procman); what is put in is never
// split again. Nothing and `why` when a quote is not closed or there is no program.
std::optional<ExecLine> parse_exec_line(const std::string& exec, const Environment& environment,
                                        std::string* why);

}  // namespace fusion_slam
