//! The chip's main loop, as simavr has it, with what simavr leaves out.
//!
//! Holds the order of instruction, timers, sleep and interrupts, resets and
//! what they do to the clock, and the time that the two-wire bus takes. Does not
//! depend on the chips on that bus.

use super::{
    CLOCK_HZ, ENTRY_CYCLES, HOST_BAUD, MAX_BAUD_ERROR, MCUSR, MCUSR_BROWN_OUT, MCUSR_EXTERNAL,
    MCUSR_POWER_ON, Nano, NanoError, RECEIVER_DEPTH, ResetKind, SRAM_LEN, SRAM_START, START_UP_CYCLES, trace,
};
use simavr_ffi as ffi;
use std::ffi::c_void;

/// SPL, SPH and DDRC, in data space.
const STACK_LOW: usize = 0x5D;
const STACK_HIGH: usize = 0x5E;
const PORT_C_DIRECTIONS: usize = 0x27;

/// No run is longer than asked for by more than this: 16 us.
const MAX_RUN_CYCLES: u64 = 256;

/// The chip between two instructions.
#[derive(Clone, Copy)]
struct Look {
    pc: u32,
    opcode: u16,
    cycle: u64,
    stack: u16,
    interrupts: bool,
}

// Not among simavr-ffi's bindings, whose generator leaves sim_core.h out.
unsafe extern "C" {
    fn avr_run_one(avr: *mut ffi::avr_t) -> ffi::avr_flashaddr_t;
}

impl Nano {
    pub(super) fn reset_core(&mut self, kind: ResetKind) {
        let cycle = self.now();
        // SAFETY: `avr` is alive; MCUSR and SRAM lie within its data space of
        // 0x900 bytes.
        unsafe {
            let data = (*self.avr.as_ptr()).data;
            let mcusr = data.add(MCUSR);
            match kind {
                ResetKind::External => *mcusr |= MCUSR_EXTERNAL,
                ResetKind::BrownOut => *mcusr |= MCUSR_BROWN_OUT,
                ResetKind::PowerOn => {
                    *mcusr = MCUSR_POWER_ON;
                    // Contents are undefined on the chip; 0xA5 shows code that relies on zeros.
                    data.add(SRAM_START).write_bytes(0xA5, SRAM_LEN);
                }
                // The core did so when the watchdog bit.
                ResetKind::Watchdog => return,
            }
            ffi::avr_reset(self.avr.as_ptr());
        }
        self.after_reset(cycle);
    }

    /// `avr_reset` zeroed simavr's clock at this cycle of ours.
    ///
    /// It did so after the watchdog was started anew, at its shortest period,
    /// as a reset by the watchdog leaves it: that bite would be as far away as
    /// the time before the reset was long. Feeding the watchdog now corrects that.
    fn after_reset(&mut self, cycle: u64) {
        const FEED_WATCHDOG: u32 = u32::from_be_bytes(*b"wdtr");
        // SAFETY: `avr` is alive; this request takes no argument, and does
        // nothing to a watchdog that is off.
        unsafe { ffi::avr_ioctl(self.avr.as_ptr(), FEED_WATCHDOG, std::ptr::null_mut()) };
        self.wires().set_base(cycle);
        self.wires().bus.borrow_mut().abandon();
        self.wires().refresh_output_enable(true);
        self.twi_delayed = false;
        self.held_since.clear();
        if let Some(trace) = &mut self.trace {
            trace.cut();
        }
    }

    /// One round of simavr's main loop, for at most about `room` cycles.
    pub(super) fn step(&mut self, room: u64) -> Result<(), NanoError> {
        let avr = self.avr.as_ptr();
        let mut traced_from = None;
        // SAFETY: `avr` and its units live until `drop`. The hooks that run in
        // here get at `Wires` alone, of which `self` holds no reference.
        unsafe {
            if (*avr).state == ffi::cpu_Running as i32 {
                // simavr runs on until the next timer or interrupt by itself; a
                // timer that is set meanwhile lets it run on to that one, up to
                // the limit.
                (*avr).run_cycle_limit = room.min(MAX_RUN_CYCLES);
                (*avr).run_cycle_count = (*avr).run_cycle_count.min((*avr).run_cycle_limit);
                if self.trace.is_some() {
                    (*avr).run_cycle_limit = 1;
                    (*avr).run_cycle_count = 1;
                    traced_from = Some(self.look());
                }
                (*avr).pc = avr_run_one(avr);
            }
            let after = self.look();
            if !self.held_since.is_empty() {
                self.note_received(after.cycle);
            }
            let pending = (*self.twi.as_ptr()).next_twstate;
            if pending == 0 {
                self.twi_delayed = false;
            } else if !self.twi_delayed {
                self.delay_twi(pending);
            }

            let before = (*avr).cycle;
            let sleep = ffi::avr_cycle_timer_process(avr);
            if (*avr).cycle < before {
                self.counters.watchdog_resets += 1;
                let cycle = self.wires().base() + before;
                self.wires().cut_outgoing_at(cycle);
                self.after_reset(cycle);
                self.held = Some((cycle + START_UP_CYCLES, ResetKind::Watchdog));
                return Ok(());
            }
            let woke_at = (*avr).cycle;
            if (*avr).state == ffi::cpu_Sleeping as i32 {
                if (*avr).sreg[ffi::S_I as usize] == 0 {
                    return Err(NanoError::AsleepForEver { pc: (*avr).pc, cycle: self.now() });
                }
                (*avr).cycle += sleep.min(room).max(1);
            }
            let state = (*avr).state;
            let running = state == ffi::cpu_Running as i32 || state == ffi::cpu_Sleeping as i32;
            if state == ffi::cpu_Crashed as i32 || (running && (*avr).pc >= (*avr).codeend) {
                return Err(NanoError::Crashed { pc: (*avr).pc, cycle: self.now() });
            }
            if !running {
                return Err(NanoError::AsleepForEver { pc: (*avr).pc, cycle: self.now() });
            }
            let slept = (*avr).cycle - woke_at;
            let entered = self.service_interrupts();
            if let Some(before) = traced_from {
                self.note(before, after, slept, entered);
            }
        }
        Ok(())
    }

    /// Enters the handler that is due, in the time that the chip takes for it.
    fn service_interrupts(&mut self) -> Option<u8> {
        const VECTOR_LEN: u32 = 4;

        let avr = self.avr.as_ptr();
        // SAFETY: `avr` lives until `drop`; no hook of ours runs in here.
        unsafe {
            if (*avr).interrupt_state == 0 {
                return None;
            }
            let enabled = (*avr).sreg[ffi::S_I as usize] != 0;
            ffi::avr_service_interrupts(avr);
            // simavr clears I exactly when it enters a handler.
            if !enabled || (*avr).sreg[ffi::S_I as usize] != 0 {
                return None;
            }
            (*avr).cycle += ENTRY_CYCLES;
            (*avr).run_cycle_count = (*avr).run_cycle_count.saturating_sub(ENTRY_CYCLES).max(1);
            Some(((*avr).pc / VECTOR_LEN) as u8)
        }
    }

    fn look(&self) -> Look {
        // SAFETY: `avr` lives until `drop`; its registers lie within the data
        // space, and an instruction always has two bytes of flash behind it.
        unsafe {
            let avr = self.avr.as_ptr();
            let pc = (*avr).pc;
            let register = |address: usize| *(*avr).data.add(address);
            let word = (*avr).flash.add(pc.min((*avr).flashend - 1) as usize).cast::<[u8; 2]>();
            Look {
                pc,
                opcode: u16::from_le_bytes(*word),
                cycle: self.now(),
                stack: u16::from_le_bytes([register(STACK_LOW), register(STACK_HIGH)]),
                interrupts: (*avr).sreg[ffi::S_I as usize] != 0,
            }
        }
    }

    fn note(&mut self, before: Look, after: Look, slept: u64, entered: Option<u8>) {
        let now = self.now();
        let Some(trace) = &mut self.trace else { return };
        // SAFETY: `avr` lives until `drop`; data space has DATA_LEN bytes, and
        // nothing writes to it while the program stands.
        let (data, bus_busy) = unsafe {
            let data = std::slice::from_raw_parts((*self.avr.as_ptr()).data, SRAM_START + SRAM_LEN);
            (data, (*self.twi.as_ptr()).state != 0)
        };
        trace.note(&trace::Step {
            pc: before.pc,
            next_pc: after.pc,
            opcode: before.opcode,
            began: before.cycle,
            ended: after.cycle,
            stack_before: before.stack,
            stack_after: after.stack,
            interrupts_before: before.interrupts,
            interrupts_after: after.interrupts,
            entered: entered.map(|vector| (vector, now)),
            slept,
            bus_busy,
            directions: data[PORT_C_DIRECTIONS],
            data,
        });
    }

    /// Gives the START or address under way the time it takes on the bus, and
    /// a bus that is stuck all the time in the world.
    fn delay_twi(&mut self, pending: u8) {
        const START: u8 = 0x08;
        const REPEATED_START: u8 = 0x10;
        const ADDRESS_ACK: u8 = 0x18;
        const ADDRESS_NACK: u8 = 0x20;

        let bits = match pending {
            START | REPEATED_START => 1,
            ADDRESS_ACK | ADDRESS_NACK => 9,
            _ => 0,
        };
        let stuck = self.wires().bus.borrow().is_stuck();
        self.twi_delayed = true;
        if bits == 0 && !stuck {
            return;
        }
        let avr = self.avr.as_ptr();
        // SAFETY: the timer list belongs to `avr` and is walked only while
        // simavr stands; registering and cancelling are its own functions.
        unsafe {
            let mut slot = (*avr).cycle_timers.timer;
            while !slot.is_null() && (*slot).param != self.twi.as_ptr().cast::<c_void>() {
                slot = (*slot).next;
            }
            if slot.is_null() {
                return;
            }
            let (timer, param) = ((*slot).timer, (*slot).param);
            if stuck {
                ffi::avr_cycle_timer_cancel(avr, timer, param);
                (*self.twi.as_ptr()).next_twstate = 0;
            } else {
                // Section 21.5.2: 16 + 2 TWBR 4^TWPS cycles a bit.
                const TWBR: usize = 0xB8;
                const TWSR: usize = 0xB9;
                let divider = u64::from(*(*avr).data.add(TWBR)) << (2 * (*(*avr).data.add(TWSR) & 3));
                ffi::avr_cycle_timer_register(avr, bits * (16 + 2 * divider), timer, param);
            }
        }
    }

    /// Hands the first byte on the line, whole by now, to the receiver.
    pub(super) fn deliver(&mut self) {
        let Some((_, byte)) = self.incoming.pop_front() else { return };
        let bit_cycles = self.wires().bit_cycles() as f64;
        let error = bit_cycles * HOST_BAUD as f64 / CLOCK_HZ as f64 - 1.0;
        if error.abs() > MAX_BAUD_ERROR {
            self.counters.framing_errors += 1;
            return;
        }
        let uart = self.uart.as_ptr();
        // SAFETY: `uart` and its input belong to `avr`, which is alive and not
        // running.
        unsafe {
            if self.bytes_held() >= RECEIVER_DEPTH {
                self.counters.receiver_overruns += 1;
                return;
            }
            // simavr counts from the start bit; ours has been on the line already.
            let byte_cycles = std::mem::replace(&mut (*uart).cycles_per_byte, 1);
            ffi::avr_raise_irq(self.uart_input.as_ptr(), u32::from(byte));
            (*uart).cycles_per_byte = byte_cycles;
        }
        self.held_since.push_back(self.now());
    }

    /// Bytes in the receiver that the program has not read.
    fn bytes_held(&self) -> u16 {
        // SAFETY: `uart` belongs to `avr`, which is alive.
        let input = unsafe { &(*self.uart.as_ptr()).input };
        input.write.wrapping_sub(input.read) % 64
    }

    /// The program may just have read a byte.
    fn note_received(&mut self, now: u64) {
        while self.held_since.len() > usize::from(self.bytes_held()) {
            let Some(since) = self.held_since.pop_front() else { return };
            if let Some(trace) = &mut self.trace {
                trace.interrupts.note_receive_wait(now - since);
            }
        }
    }
}
