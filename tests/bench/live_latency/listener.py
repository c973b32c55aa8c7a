"""Hears everything on an LCM network (udpm), each message with the kernel's time of its last packet.

LCM's packets (its wire format, big endian): magic, number, then for a short message the channel and
the content; for a long one size, offset, fragment and number of fragments, with the channel in the
first fragment."""
import socket, struct, threading

GROUP, PORT = "239.255.76.67", 7667
SHORT, LONG = 0x4C433032, 0x4C433033
SO_TIMESTAMPNS = 35  # Linux; the socket module has no name for it
ENOUGH = 64          # bytes of a message nobody needs whole: utime, seq, id


class Listener:
    """messages: (time in s, channel, content) in the order of arrival; content is cut to the first
    bytes unless the channel is one of `whole`. lost: packets that this listener missed."""

    def __init__(self, whole):
        self.whole, self.messages, self.lost = whole, [], 0
        self.numbers, self.parts = {}, {}
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.socket.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 8 << 20)
        self.socket.bind((GROUP, PORT))
        self.socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP,
                               socket.inet_aton(GROUP) + socket.inet_aton("127.0.0.1"))
        self.socket.settimeout(0.2)
        self.stopping = False
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def stop(self):
        self.stopping = True
        self.thread.join()

    def run(self):
        while not self.stopping:
            try:
                packet, about, _, sender = self.socket.recvmsg(65536, 128)
            except socket.timeout:
                continue
            at = next((s + ns * 1e-9 for level, kind, data in about if kind == SO_TIMESTAMPNS
                       for s, ns in [struct.unpack("qq", data)]), None)
            self.take(at, packet, sender)

    def count(self, sender, number):
        before = self.numbers.get(sender)
        self.numbers[sender] = number
        if before is not None and number != before:  # parts of one message share it
            self.lost += max(0, (number - before - 1) & 0xFFFFFFFF if number > before else 0)

    def take(self, at, packet, sender):
        if len(packet) < 8:
            return
        magic, number = struct.unpack_from(">II", packet)
        if magic == SHORT:
            self.count(sender, number)
            channel, _, content = packet[8:].partition(b"\0")
            return self.say(at, channel.decode(), content)
        if magic != LONG:
            return
        self.count(sender, number)
        size, offset, part, parts = struct.unpack_from(">IIHH", packet, 8)
        key, content = (sender, number), packet[20:]
        if part == 0:
            channel, _, content = content.partition(b"\0")
            self.parts[key] = [channel.decode(), {}, 0]
        if key not in self.parts:
            self.lost += 1
            return
        message = self.parts[key]
        message[2] += 1
        if part == 0 or message[0] in self.whole:
            message[1][offset] = content
        if message[2] == parts:
            del self.parts[key]
            self.say(at, message[0], b"".join(message[1][o] for o in sorted(message[1])))

    def say(self, at, channel, content):
        self.messages.append((at, channel, content if channel in self.whole else content[:ENOUGH]))
