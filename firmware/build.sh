#!/usr/bin/env bash
# Compiles a sketch for an Arduino Uno with Debian's gcc-avr, avr-libc and arduino-core-avr: firmware/build.sh SKETCH OUT.hex
set -euo pipefail
sketch=$1 out=$2
arduino=/usr/share/arduino/hardware/arduino/avr
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# WString.cpp asks for a constant that this gcc's float.h has for C alone.
flags=(-mmcu=atmega328p -DF_CPU=16000000L -DARDUINO=10819 -DARDUINO_AVR_UNO -DARDUINO_ARCH_AVR -DDECIMAL_DIG=__DECIMAL_DIG__
    -Os -ffunction-sections -fdata-sections "-I$arduino/cores/arduino" "-I$arduino/variants/standard")
cpp=(-std=gnu++11 -fno-exceptions -fno-threadsafe-statics)
for file in "$arduino"/cores/arduino/*.c; do avr-gcc "${flags[@]}" -w -c "$file" -o "$work/$(basename "$file").o"; done
for file in "$arduino"/cores/arduino/*.cpp; do avr-g++ "${flags[@]}" "${cpp[@]}" -w -c "$file" -o "$work/$(basename "$file").o"; done
avr-gcc "${flags[@]}" -x assembler-with-cpp -c "$arduino/cores/arduino/wiring_pulse.S" -o "$work/wiring_pulse.S.o"
avr-g++ "${flags[@]}" "${cpp[@]}" -Wall -Wextra -Werror -x c++ -include Arduino.h -c "$sketch"/*.ino -o "$work/sketch.o"
avr-g++ "${flags[@]}" -Wl,--gc-sections "$work"/*.o -o "$work/sketch.elf"
avr-objcopy -O ihex -R .eeprom "$work/sketch.elf" "$out"
avr-size "$work/sketch.elf" | tail -1 | awk '{ print $1 + $2 " bytes of 32256, " $2 + $3 " of 2048 of memory" }'
