// Ctrl-C as a flag: the first asks for a partial result, the second gives up waiting for it.
#pragma once

namespace fusion_slam {

void watch_interrupts();  // SIGINT, SIGTERM and SIGHUP of this process
int interrupts();         // how many have come

}  // namespace fusion_slam
