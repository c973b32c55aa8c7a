// Machines of a lab for tests/faults/run: network namespaces joined by a switch, 0 (who watches),
// 1, 2 and 3. Prints how to run something on each as one JSON list, then reads commands from its
// input, one a line: `cut N`, `join N` (its cable out and in), `disturb N LOSS DELAY_MS JITTER_MS`,
// `quit`.
#include <iostream>
#include <sstream>

#include <nlohmann/json.hpp>

#include "tests/support/lab_network.hpp"

int main() {
  using namespace fusion_slam;
  constexpr int kMachines = 3;
  std::string why;
  const auto network = LabNetwork::make(kMachines, &why);
  if (!network) {
    std::cerr << "fault_machines: " << why << std::endl;
    return 1;
  }
  nlohmann::json prefixes{{"nsenter", "-t", std::to_string(getpid()), "-n"}};
  for (int i = 1; i <= kMachines; ++i) prefixes.push_back(network->on(i, {}));
  std::cout << prefixes.dump() << std::endl;
  std::string line;
  while (std::getline(std::cin, line) && line != "quit") {
    std::istringstream words(line);
    std::string verb;
    int machine = -1;
    words >> verb >> machine;
    WireFaults faults;
    words >> faults.loss >> faults.delay_ms >> faults.jitter_ms;
    if (machine < 0 || machine > kMachines) {
      std::cerr << "fault_machines: no such machine: " << line << std::endl;
      continue;
    }
    if (verb == "cut")
      network->cut(machine);
    else if (verb == "join")
      network->join(machine);
    else if (verb == "disturb")
      network->disturb(machine, faults);
    else
      std::cerr << "fault_machines: no such command: " << line << std::endl;
  }
  return 0;
}
