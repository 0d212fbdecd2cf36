// SPDX-License-Identifier: Apache-2.0
//
// wh_modbus: a Modbus RTU slave on the bus of the settings memory (wh_registers), by the standards
// "MODBUS Application Protocol 1.1b3" and "MODBUS over serial line 1.02".
//
//   functions 3, 4    read registers (holding and input registers are the same)
//             6, 16   write a word by its low register, whole words
//             43/14   basic device identification: vendor, product code, revision
//   0x0000...0x0017   identification, counters, and the line's rate: 12 words
//   0x2000...0x3fff   the word at address a of the table: 0x2000 + 2a its high half, + 1 the low one
//
// A frame's end is told by its function and length, of unknown functions by silence. Nothing is done
// before its CRC was right. Silence, of SILENCE to 2 SILENCE clocks, also ends what a broken frame has
// left. What comes meanwhile waits, up to 255 bytes; each byte keeps what was wrong before it.
//
// All words of a frame are first judged by the bus (bus_check_o), then written, and given together by
// a write to `commit`; if one is refused, none is written. Were one refused only then, as the
// bridges have come on in between, `discard` forgets the others. Every half of a word that is read
// comes from one reading of it. Function 6 writes a word's low register; its high half is
// made of the sign if the word has one, else 0. `commit` and `discard` themselves can't be written.
// Where the bus has error 3, for a setting or a command that acts with the bridges off, the frame waits until
// the memory isn't busy and is judged once more. Other frames of commands wait for nothing.
//
// Exceptions: 1 function, 2 address, 3 quantity or value, 4 the bus doesn't answer, 6 not now (the
// bus's error 3, after up to SILENCE to 2 SILENCE of a busy memory). Broadcasts are done without an answer,
// to others nothing is done. Counters go on through a reset, and can't be written.
//
// rate_o, 0 at first, is written by word 5; it changes after the answer, and back to 0 after FALLBACK
// times SILENCE clocks without a whole frame whose CRC was right; lost_o is high in the last clock of these.
//
// With framed_i bytes come in transfers (wh_spi): the end of one takes the place of silence, so frames may follow each
// other in one, but none goes on in the next. A byte of 248 to 255 in place of a unit is no frame, and nor is the rest
// of its transfer: a master sends it to read. idle_o: no frame has begun and no answer waits; framed_i may change.
//
// Latency: of a frame of w words 3w times 18 clocks and the bus's own, then the answer. Reset: idle,
// at rate 0; what was received is forgotten.

`default_nettype none
`include "wh_words.vh"

module wh_modbus #(
    parameter integer UNIT     = 1,       // 1...247
    parameter integer CLOCK_HZ = 24000000,
    parameter integer RATES    = 4,       // 1...4: rate_o is below
    parameter integer SILENCE  = CLOCK_HZ / 500,
    parameter integer FALLBACK = 500,     // 2...511
    parameter [31:0]  BUILD    = 32'd0,
    parameter [31:0]  OPTIONS  = 32'd0,
    parameter integer MOTORS   = 1
) (
    input  wire        clk,
    input  wire        rst,

    // The line.
    input  wire        rx_valid_i,  // strobe
    input  wire        rx_error_i,  // with the strobe: the byte was none
    input  wire [7:0]  rx_data_i,
    input  wire        framed_i,
    input  wire        ends_i,      // strobe: a transfer has ended
    output wire        tx_valid_o,
    output wire [7:0]  tx_data_o,
    input  wire        tx_ready_i,  // high where nothing is on its way any more
    output wire        answers_o,   // an answer's bytes come, from before the first one to the last
    output wire        rests_o,     // then, and without an answer as well: tx_ready_i is waited for
    output wire [1:0]  rate_o,
    output wire        idle_o,
    output wire        lost_o,      // strobe

    // The bus.
    output wire        bus_valid_o,
    output wire        bus_write_o,
    output wire        bus_check_o,
    output wire [11:0] bus_address_o,
    output wire [31:0] bus_data_o,
    input  wire        bus_ready_i,
    input  wire [31:0] bus_data_i,
    input  wire [1:0]  bus_error_i,
    input  wire        bus_signed_i
);

    generate
        if (UNIT < 1 || UNIT > 247) begin : illegal_unit
            wh_illegal_parameter_modbus_unit_must_be_1_to_247 stop ();
        end
        if (RATES < 1 || RATES > 4) begin : illegal_rates
            wh_illegal_parameter_modbus_rates_must_be_1_to_4 stop ();
        end
        if (SILENCE < 2 || FALLBACK < 2 || FALLBACK > 511) begin : illegal_times
            wh_illegal_parameter_modbus_silence_or_fallback stop ();
        end
    endgenerate

    // ---- Identification: 0...0x2f are the bytes of 12 words, with the counters from 0x20 on; from
    // 0x40, 0x80 and 0xc0 on what answers function 43/14 from object 0, 1 or 2 on.

    localparam [31:0] VERSION  = 32'd1;  // of the registers' map
    localparam [31:0] CLOCK_32 = CLOCK_HZ;
    localparam [31:0] MOTORS_32 = MOTORS;
    localparam [31:0] RATES_32 = RATES;
    localparam [8*32-1:0] IDENTITY =
        {`WH_WORDS_CRC, BUILD, OPTIONS, CLOCK_32, MOTORS_32, 32'd0, VERSION, RATES_32};
    localparam [8*14-1:0] VENDOR   = {8'd0, 8'd12, "wave haptics"};
    localparam [8*12-1:0] PRODUCT  = {8'd1, 8'd10, "controller"};
    localparam [8*8-1:0]  REVISION = {8'd2, 8'd6, "v0.2.0"};
    localparam [8*38-1:0] OBJECTS_0 = {32'h01000003, VENDOR, PRODUCT, REVISION};
    localparam [8*24-1:0] OBJECTS_1 = {32'h01000002, PRODUCT, REVISION};
    localparam [8*12-1:0] OBJECTS_2 = {32'h01000001, REVISION};

    localparam [10:0] RATE_WORD = 11'd5;

    // 0...255 the frame or the answer, 256...511 the identification.
    (* ram_style = "block" *) reg [7:0] memory [0:511];

    integer i;

    initial begin
        for (i = 0; i < 512; i = i + 1) begin
            memory[i] = 8'd0;
        end
        for (i = 0; i < 32; i = i + 1) begin
            memory['h100 + i] = IDENTITY[8*(31 - i) +: 8];
        end
        for (i = 0; i < 38; i = i + 1) begin
            memory['h140 + i] = OBJECTS_0[8*(37 - i) +: 8];
        end
        for (i = 0; i < 24; i = i + 1) begin
            memory['h180 + i] = OBJECTS_1[8*(23 - i) +: 8];
        end
        for (i = 0; i < 12; i = i + 1) begin
            memory['h1c0 + i] = OBJECTS_2[8*(11 - i) +: 8];
        end
    end

    // ---- Time.

    localparam integer SILENCE_W = $clog2(SILENCE);
    localparam [31:0]  PERIOD_END = SILENCE - 1;
    localparam [31:0]  LAST_PERIOD = FALLBACK - 1;

    reg  [SILENCE_W-1:0] period_q;
    reg  [1:0]           quiet_q;    // periods that have ended since the last byte, no more than 2
    reg  [8:0]           unheard_q;  // since the last good frame
    wire                 period = (period_q == PERIOD_END[SILENCE_W-1:0]);
    wire                 quiet  = quiet_q[1];
    wire                 unheard = (unheard_q == LAST_PERIOD[8:0]);

    always @(posedge clk) begin
        if (rst) begin
            period_q <= {SILENCE_W{1'b0}};
            quiet_q  <= 2'd0;
        end else begin
            period_q <= period ? {SILENCE_W{1'b0}} : period_q + 1'b1;
            if (rx_valid_i) begin
                quiet_q <= 2'd0;
            end else if (framed_i) begin
                quiet_q <= ends_i ? 2'd2 : quiet_q;
            end else if (period && !quiet) begin
                quiet_q <= quiet_q + 2'd1;
            end
        end
    end

    // ---- What was received: a byte; whether it was none; that bytes before it were lost, and that
    // there was silence before it.

    (* ram_style = "block" *) reg [10:0] received [0:255];

    reg  [7:0]  write_q;
    reg  [7:0]  read_q;
    reg         lost_q;
    reg  [10:0] read_out_q;  // what block RAM puts out comes late in its clock: it gets one more
    reg  [10:0] taken_q;
    wire [7:0]  after_write = write_q + 8'd1;
    wire        full  = (after_write == read_q);
    wire        there = (write_q != read_q);
    wire        pop;
    wire        owns_up;  // what was lost came last

    always @(posedge clk) begin
        if (rx_valid_i && !full) begin
            received[write_q] <= {quiet, lost_q, rx_error_i, rx_data_i};
        end
        read_out_q <= received[read_q];
        taken_q    <= read_out_q;
        if (rst) begin
            write_q <= 8'd0;
            read_q  <= 8'd0;
            lost_q  <= 1'b0;
        end else begin
            if (rx_valid_i) begin
                lost_q <= full;
                if (!full) begin
                    write_q <= after_write;
                end
            end else if (owns_up) begin
                lost_q <= 1'b0;
            end
            if (pop) begin
                read_q <= read_q + 8'd1;
            end
        end
    end

    wire [7:0] byte_in = taken_q[7:0];
    wire       gap     = taken_q[10];
    wire       broken  = |taken_q[9:8];

    // ---- The sequence.

    localparam [4:0] GET    = 5'd0;   // wait for a byte
    localparam [4:0] TAKE   = 5'd1;   // it is judged by its place
    localparam [4:0] SHIFT  = 5'd2;   // it goes into the CRC
    localparam [4:0] NEXT   = 5'd3;
    localparam [4:0] END    = 5'd4;   // there was silence
    localparam [4:0] COUNT  = 5'd5;   // a counter's byte is read
    localparam [4:0] CARRY  = 5'd6;   // and written
    localparam [4:0] POLL   = 5'd7;   // a setting is refused: wait until the memory isn't busy
    localparam [4:0] HEAD   = 5'd8;   // the frame's bytes 2 to 5 are read
    localparam [4:0] JUDGE  = 5'd9;
    localparam [4:0] LENGTH = 5'd10;  // the answer's number of bytes is written
    localparam [4:0] WORD   = 5'd11;  // the next word's address is judged
    localparam [4:0] LOAD   = 5'd12;  // four bytes of the memory are read
    localparam [4:0] ASK    = 5'd13;  // the bus
    localparam [4:0] RATE   = 5'd14;
    localparam [4:0] DROP   = 5'd15;  // the high half isn't asked for
    localparam [4:0] EMIT   = 5'd16;  // a half goes into the answer
    localparam [4:0] STEP   = 5'd17;  // to the next register
    localparam [4:0] STAGED = 5'd18;  // is there anything to be given?
    localparam [4:0] GIVE   = 5'd19;
    localparam [4:0] ANSWER = 5'd20;
    localparam [4:0] SEND   = 5'd21;
    localparam [4:0] SENT   = 5'd22;
    localparam [4:0] REST   = 5'd23;  // the answer is on its way
    localparam [4:0] HEAR   = 5'd24;  // the byte comes out of the memory

    localparam [1:0] FRAMES   = 2'd0;  // counters
    localparam [1:0] CRCS     = 2'd1;
    localparam [1:0] FRAMINGS = 2'd2;
    localparam [1:0] OVERRUNS = 2'd3;

    localparam [2:0] FUNCTION = 3'd1;  // exceptions
    localparam [2:0] ADDRESS  = 3'd2;
    localparam [2:0] VALUE    = 3'd3;
    localparam [2:0] FAILURE  = 3'd4;
    localparam [2:0] NOT_NOW  = 3'd6;

    localparam [31:0] UNIT_32 = UNIT;

    reg  [4:0]  state_q;
    reg  [4:0]  state_d;
    reg  [2:0]  step_q;      // clocks that the state has lasted, 7 or more
    reg  [7:0]  place_q;     // in the frame, the answer or the counters
    reg  [7:0]  end_q;       // the frame's last place, the answer's length
    reg  [15:0] crc_q;
    reg  [31:0] data_q;      // the word, or the head
    reg  [15:0] address_q;   // the register
    reg  [6:0]  count_q;     // registers still to be done
    reg  [1:0]  pass_q;      // 0 the sign is asked for, 1 words are judged, 2 written
    reg  [7:0]  from_ram_q;  // what the memory puts out, late in its clock
    reg  [7:0]  read_data_q; // the same, a clock later

    reg         skip_q;      // until there is silence
    reg         mine_q;      // for this unit or for all
    reg         all_q;
    reg         reads_q;
    reg         writes_q;
    reg         one_q;       // of these function 6
    reg         names_q;     // function 43/14
    reg         open_q;      // the length isn't known
    reg         whole_q;
    reg         sends_q;
    reg  [1:0]  tail_q;      // bytes of the CRC, 1 and 2
    reg         extend_q;    // the sign of function 6
    reg         waited_q;    // the memory isn't busy any more
    reg         refused_q;
    reg  [2:0]  code_q;
    reg  [1:0]  counter_q;
    reg  [1:0]  late_q;      // periods on the bus
    reg  [1:0]  rate_q;
    reg  [1:0]  new_rate_q;

    wire       begun    = skip_q || (place_q != 8'd0);
    wire       at_end   = (place_q == end_q);
    wire       good     = (crc_q == 16'd0);
    wire       closes   = open_q && good && (place_q[7:2] != 6'd0);  // an open frame's CRC is right
    wire       breaks   = gap && begun;
    wire       filler   = framed_i && (place_q == 8'd0) && (&byte_in[7:3]);
    wire       passes   = skip_q || filler;
    wire       stores   = (state_q == TAKE) && !breaks && !broken && !passes;
    wire       hangs    = (&late_q) && !bus_ready_i;
    wire       waits    = (state_q == ASK) && bus_ready_i && (bus_error_i == 2'd3) && (pass_q == 2'd1) && !waited_q;
    wire       reads_out = (state_q == SEND) && (step_q[2:1] != 2'd0);
    wire       has_next = reads_out && tx_ready_i;
    wire       last     = (count_q == 7'd1);
    wire       drops    = skip_q || (closes && !mine_q);  // what ended was no frame for this unit

    assign pop     = (state_q == TAKE) && !breaks;
    assign owns_up = (state_q == GET) && !there && lost_q && !rx_valid_i;

    // The head.
    wire [15:0] quantity   = data_q[15:0];
    wire        few        = (quantity[15:7] == 9'd0) && (quantity[6:0] != 7'd0);
    wire        read_fits  = few && (quantity[6:0] < 7'd126);
    wire        write_fits = one_q || (few && (quantity[6:0] < 7'd123) && !quantity[0]
                                       && read_data_q == {quantity[6:0], 1'b0});
    wire        names_fit  = (data_q[23:18] == 6'd0) && (data_q[17:16] != 2'd0);
    wire        fits       = reads_q ? read_fits : writes_q ? write_fits : names_fit;
    wire [1:0]  object     = (data_q[15:10] != 6'd0 || data_q[9:8] == 2'd3) ? 2'd0 : data_q[9:8];

    // The register.
    wire table_word = (address_q[15:13] == 3'd1);
    wire rate_word  = (address_q[15:1] == {4'd0, RATE_WORD});
    wire own_word   = (address_q[15:5] == 11'd0) && (address_q[4:3] != 2'd3);
    wire giving     = (address_q[12:2] == 11'h038);
    wire word_fits  = writes_q ? ((table_word && !giving) || rate_word)
                               : (table_word || own_word || names_q);
    wire rate_fits  = (data_q[31:2] == 30'd0) && ({1'b0, data_q[1:0]} < RATES_32[2:0]);

    // From the memory to a state is too long a way for a clock: JUDGE lasts two, CARRY three.
    wire       carries = (state_q == CARRY) && step_q[1];
    reg        fits_q;
    reg        ones_q;

    always @(posedge clk) begin
        fits_q <= fits;
        ones_q <= &read_data_q;
    end

    wire       ripples = ones_q && !(&place_q[1:0]);  // a counter's next byte counts as well

    reg        refuses;
    reg  [2:0] code;

    always @* begin
        state_d = state_q;
        refuses = 1'b0;
        code    = ADDRESS;
        case (state_q)
            GET:    state_d = there ? HEAR : owns_up ? COUNT : (quiet && begun) ? END : GET;
            HEAR:   state_d = TAKE;
            TAKE:   state_d = breaks ? END : broken ? COUNT : passes ? GET : SHIFT;
            SHIFT:  state_d = (step_q != 3'd7) ? SHIFT : sends_q ? SENT : NEXT;
            NEXT:   state_d = whole_q ? ((good && !mine_q) ? GET : COUNT)
                            : (&place_q) ? COUNT : GET;
            END:    state_d = drops ? GET : COUNT;
            COUNT:  state_d = CARRY;
            CARRY: begin
                if (!carries) begin
                    state_d = CARRY;
                end else if (ripples) begin
                    state_d = COUNT;
                end else if (counter_q != FRAMES) begin
                    state_d = GET;
                end else if (all_q && !writes_q) begin
                    state_d = REST;
                end else if (reads_q || names_q || writes_q) begin
                    state_d = HEAD;
                end else begin
                    state_d = ANSWER;
                    refuses = 1'b1;
                    code    = FUNCTION;
                end
            end
            POLL: begin
                if (bus_ready_i && !bus_data_i[0]) begin
                    state_d = HEAD;
                end else if (late_q[1] && (bus_ready_i || late_q[0])) begin
                    state_d = ANSWER;
                    refuses = 1'b1;
                    code    = bus_ready_i ? NOT_NOW : FAILURE;
                end
            end
            HEAD:   state_d = (step_q == 3'd5) ? JUDGE : HEAD;
            JUDGE: begin
                if (step_q == 3'd0) begin
                    state_d = JUDGE;
                end else begin
                    if (!fits_q) begin
                        refuses = 1'b1;
                        code    = VALUE;
                    end else if (writes_q && data_q[16] != one_q) begin
                        refuses = 1'b1;
                    end
                    state_d = refuses ? ANSWER : reads_q ? LENGTH : WORD;
                end
            end
            LENGTH: state_d = WORD;
            WORD: begin
                refuses = !word_fits;
                state_d = refuses ? ANSWER : (table_word && !writes_q) ? ASK : LOAD;
            end
            LOAD: begin
                if (step_q == 3'd5) begin
                    state_d = !writes_q ? (address_q[0] ? DROP : EMIT) : table_word ? ASK : RATE;
                end
            end
            ASK: begin
                if (bus_ready_i || hangs) begin
                    refuses = hangs || (bus_error_i != 2'd0 && !(writes_q && pass_q == 2'd0) && !waits);
                    code    = hangs ? FAILURE : (bus_error_i == 2'd1) ? ADDRESS
                                              : (bus_error_i == 2'd2) ? VALUE : NOT_NOW;
                    state_d = waits ? POLL : refuses ? (pass_q[1] ? STAGED : ANSWER)
                            : writes_q ? STEP : address_q[0] ? DROP : EMIT;
                end
            end
            RATE: begin
                refuses = !rate_fits;
                code    = VALUE;
                state_d = refuses ? ANSWER : STEP;
            end
            DROP:   state_d = step_q[0] ? EMIT : DROP;
            EMIT:   state_d = step_q[0] ? STEP : EMIT;
            STEP: begin
                if (last) begin
                    state_d = !writes_q ? ANSWER : pass_q[1] ? STAGED : HEAD;
                end else begin
                    state_d = address_q[0] ? WORD : writes_q ? STEP : EMIT;
                end
            end
            STAGED: begin
                if (bus_ready_i || hangs) begin
                    refuses = hangs;
                    code    = FAILURE;
                    state_d = (bus_ready_i && bus_data_i[0]) ? GIVE : ANSWER;
                end
            end
            GIVE: begin
                if (bus_ready_i || hangs) begin
                    refuses = hangs || (bus_error_i != 2'd0 && !refused_q);
                    code    = hangs ? FAILURE : NOT_NOW;
                    state_d = (refuses && !hangs) ? STAGED : ANSWER;
                end
            end
            ANSWER: state_d = all_q ? REST : SEND;
            SEND:   state_d = has_next ? SHIFT : SEND;
            SENT:   state_d = tail_q[1] ? REST : SEND;
            default: state_d = tx_ready_i ? GET : REST;
        endcase
    end

    wire reads_head = (state_q == HEAD) || (state_q == LOAD);
    wire asks       = (state_q == POLL) || (state_q == ASK) || (state_q == STAGED)
                      || (state_q == GIVE);

    always @(posedge clk) begin
        step_q <= (state_d != state_q) ? 3'd0 : (&step_q) ? step_q : step_q + 3'd1;
        late_q <= !asks ? 2'd0 : (period && !(&late_q)) ? late_q + 2'd1 : late_q;
        if (rst) begin
            state_q    <= GET;
            place_q    <= 8'd0;
            skip_q     <= 1'b0;
            sends_q    <= 1'b0;
            rate_q     <= 2'd0;
            new_rate_q <= 2'd0;
            unheard_q  <= 9'd0;
        end else begin
            state_q <= state_d;

            if (refuses && !refused_q) begin
                refused_q <= 1'b1;
                code_q    <= code;
            end
            if (period) begin
                unheard_q <= unheard_q + 9'd1;
                if (unheard) begin
                    unheard_q  <= 9'd0;
                    rate_q     <= 2'd0;
                    new_rate_q <= 2'd0;
                end
            end

            case (state_q)
                GET: begin
                    if (place_q == 8'd0) begin
                        end_q <= 8'hff;  // until the function says more
                    end
                    if (owns_up) begin
                        skip_q    <= 1'b1;
                        counter_q <= OVERRUNS;
                        place_q   <= {4'b0010, OVERRUNS, 2'd0};
                    end
                end
                TAKE: begin
                    refused_q <= 1'b0;
                    waited_q  <= 1'b0;
                    pass_q    <= 2'd0;
                    extend_q  <= 1'b0;
                    tail_q    <= 2'd0;
                    if (!breaks && broken) begin
                        skip_q    <= 1'b1;
                        counter_q <= taken_q[9] ? OVERRUNS : FRAMINGS;
                        place_q   <= {4'b0010, taken_q[9] ? OVERRUNS : FRAMINGS, 2'd0};
                    end else if (!breaks && filler) begin
                        skip_q    <= 1'b1;
                    end
                    if (stores) begin
                        whole_q <= at_end && !open_q && !(writes_q && !one_q && place_q == 8'd6);
                        case (place_q)
                            8'd0: begin
                                all_q  <= (byte_in == 8'd0);
                                mine_q <= (byte_in == 8'd0) || (byte_in == UNIT_32[7:0]);
                            end
                            8'd1: begin
                                reads_q  <= (byte_in == 8'd3) || (byte_in == 8'd4);
                                writes_q <= (byte_in == 8'd6) || (byte_in == 8'd16);
                                one_q    <= (byte_in == 8'd6);
                                names_q  <= (byte_in == 8'd43);
                                open_q   <= (byte_in != 8'd3) && (byte_in != 8'd4) && (byte_in != 8'd6)
                                            && (byte_in != 8'd16) && (byte_in != 8'd43);
                                end_q    <= (byte_in == 8'd43 || byte_in == 8'd16) ? 8'd6 : 8'd7;
                            end
                            8'd2: begin
                                if (names_q && byte_in != 8'd14) begin
                                    names_q <= 1'b0;
                                    open_q  <= 1'b1;
                                end
                            end
                            8'd6: begin
                                if (writes_q && !one_q) begin
                                    end_q  <= byte_in + 8'd8;
                                    open_q <= (byte_in >= 8'd248);
                                end
                            end
                            default: ;
                        endcase
                    end
                end
                NEXT: begin
                    place_q <= place_q + 8'd1;
                    if (whole_q) begin
                        skip_q    <= !good;
                        counter_q <= good ? FRAMES : CRCS;
                        place_q   <= (good && !mine_q) ? 8'd0 : {4'b0010, good ? FRAMES : CRCS, 2'd0};
                        if (good) begin
                            unheard_q <= 9'd0;
                        end
                    end else if (&place_q) begin
                        skip_q    <= 1'b1;
                        counter_q <= OVERRUNS;
                        place_q   <= {4'b0010, OVERRUNS, 2'd0};
                    end
                end
                END: begin
                    skip_q    <= 1'b0;
                    counter_q <= closes ? FRAMES : CRCS;
                    place_q   <= drops ? 8'd0 : {4'b0010, closes ? FRAMES : CRCS, 2'd0};
                    if (closes) begin
                        unheard_q <= 9'd0;
                    end
                end
                CARRY: begin
                    if (carries) begin
                        place_q <= ripples ? place_q + 8'd1
                                 : (counter_q == FRAMES) ? 8'd2 : 8'd0;
                    end
                end
                HEAD: begin
                    place_q <= step_q[2] ? place_q : place_q + 8'd1;
                end
                JUDGE: begin
                    address_q <= names_q ? {9'd0, object + 2'd1, 5'd0} : data_q[31:16];
                    count_q   <= one_q    ? 7'd1
                               : !names_q ? quantity[6:0]
                               : (object == 2'd0) ? 7'd19 : (object == 2'd1) ? 7'd12 : 7'd6;
                    place_q   <= names_q ? 8'd4 : (reads_q || one_q) ? 8'd2 : 8'd7;
                end
                LENGTH: begin
                    place_q <= place_q + 8'd1;
                end
                LOAD: begin
                    if (writes_q && !step_q[2]) begin
                        place_q <= place_q + 8'd1;
                    end
                end
                ASK: begin
                    if (bus_ready_i && pass_q == 2'd0) begin
                        extend_q <= one_q && bus_signed_i && data_q[15];
                    end
                    if (waits) begin
                        waited_q <= 1'b1;
                        pass_q   <= 2'd0;
                        place_q  <= 8'd2;
                    end
                end
                RATE: begin
                    if (rate_fits && pass_q[1]) begin
                        new_rate_q <= data_q[1:0];
                    end
                end
                EMIT: begin
                    place_q <= place_q + 8'd1;
                end
                STEP: begin
                    address_q <= address_q + 16'd1;
                    count_q   <= count_q - 7'd1;
                    if (last && writes_q) begin
                        pass_q  <= pass_q + 2'd1;
                        place_q <= 8'd2;
                    end
                end
                ANSWER: begin
                    sends_q <= !all_q;
                    end_q   <= refused_q ? 8'd3 : writes_q ? 8'd6 : place_q;
                    place_q <= 8'd0;
                end
                SENT: begin
                    place_q <= place_q + 8'd1;
                    if (tail_q != 2'd0 || place_q + 8'd1 == end_q) begin
                        tail_q <= tail_q + 2'd1;
                    end
                end
                REST: begin
                    place_q <= 8'd0;
                    sends_q <= 1'b0;
                    if (tx_ready_i) begin
                        rate_q <= new_rate_q;
                    end
                end
                default: ;
            endcase
        end
    end

    // ---- The word: bytes come in from below, or 32 bits from the bus.

    wire own     = (state_q == LOAD) && !writes_q;
    wire is_rate = own && rate_word && (step_q == 3'd5);
    wire fills   = one_q && (state_q == LOAD) && !step_q[2];

    wire [7:0] next_byte = fills ? {8{extend_q}} : read_data_q | {6'd0, is_rate ? rate_q : 2'd0};

    always @(posedge clk) begin
        if (bus_ready_i && ((state_q == ASK && !writes_q) || state_q == STAGED)) begin
            data_q <= bus_data_i;
        end else if (reads_head || state_q == DROP || state_q == EMIT) begin
            data_q <= (reads_head && step_q[2:1] == 2'd0) ? data_q : {data_q[23:0], next_byte};
        end
    end

    // ---- The memory.

    wire       counts  = (state_q == COUNT) || (state_q == CARRY);
    wire       emits   = (state_q == EMIT);
    wire [7:0] at      = {place_q[7:2], place_q[1:0] ^ {2{counts}}};
    wire [7:0] written = emits ? data_q[31:24]
                       : (state_q == LENGTH) ? {count_q, 1'b0}
                       : counts ? read_data_q + 8'd1 : byte_in;

    always @(posedge clk) begin
        if (stores || emits || state_q == LENGTH || carries) begin
            memory[{counts, at}] <= written;
        end
        from_ram_q  <= memory[own ? {1'b1, address_q[6:1], step_q[1:0]} : {counts, at}];
        read_data_q <= from_ram_q;
    end

    // ---- The CRC, and the answer's bytes.

    wire [7:0] plain = (refused_q && place_q == 8'd1) ? (read_data_q | 8'h80)
                     : (refused_q && place_q == 8'd2) ? {5'd0, code_q} : read_data_q;

    assign answers_o  = (state_q == ANSWER) || (sends_q && !rests_o);
    assign rests_o    = (state_q == REST);
    assign tx_valid_o = reads_out;
    assign tx_data_o  = (tail_q != 2'd0) ? crc_q[7:0] : plain;

    always @(posedge clk) begin
        if (state_q == ANSWER || (state_q == GET && place_q == 8'd0)) begin
            crc_q <= 16'hffff;
        end else if (stores) begin
            crc_q[7:0] <= crc_q[7:0] ^ byte_in;
        end else if (has_next) begin
            crc_q[7:0] <= crc_q[7:0] ^ tx_data_o;
        end else if (state_q == SHIFT) begin
            crc_q <= {1'b0, crc_q[15:1]} ^ (crc_q[0] ? 16'ha001 : 16'd0);
        end
    end

    // ---- The bus.

    assign bus_valid_o   = asks;
    assign bus_write_o   = (state_q == GIVE) || (state_q == ASK && writes_q);
    assign bus_check_o   = (state_q == ASK) && !pass_q[1];
    assign bus_address_o = (state_q == ASK) ? address_q[12:1]
                         : {10'h01c, (state_q != GIVE), (state_q == GIVE) ? refused_q : (state_q == STAGED)};
    assign bus_data_o    = data_q;

    assign rate_o = rate_q;
    assign idle_o = (state_q == GET) && !there && !begun && !lost_q;
    assign lost_o = period && unheard;

endmodule

`default_nettype wire
