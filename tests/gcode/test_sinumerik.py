"""SINUMERIK: programs with the motions that they make, worked out by hand, and wrong ones with what is said."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cncgen.geometry.tables import ArcTable
from cncgen.toolpath.record import FeedMode, Kind

#: Program, and where its motions end (X Y Z, as far as one is not 0), G0 and G1 as points, arcs as ends too.
MOTIONS: dict[str, tuple[str, list[tuple[float, ...]]]] = {
    "plain": ("G0 X1 Y2\nG1 Z-3 F100", [(1, 2, 0), (1, 2, -3)]),
    "numbers and labels": ("N10 START: G0 X1\n:20 G0 X2\n/N30 X9\nN40 X3 ; X8", [(1,), (2,), (3,)]),
    # 840D, Fundamentals, 10.2004, pp. 2-13 and 2-14; 11/2006, p. 62.
    "blanks behind the letter": ("N 10 G 0 X 1 Y -2.5\nR 1 = 3 Z=R 1 S 1=500\nIF R 01 == 3 GOTOF N 50\nX9\nN50 X 2", [(1, -2.5), (1, -2.5, 3), (2, -2.5, 3)]),
    "the head of a tape": ("%FLANGE3_MPF\nL10\nM30\n%L10_SPF\nG0 X1\nM17", [(1,)]),
    "G1 is in force": ("F100 X5", [(5,)]),
    "incremental": ("G91 G0 X1\nX1 Y2\nG90 X0", [(1,), (2, 2), (0, 2)]),
    "IC and AC": ("G0 X=IC(2) Y=AC(3)\nG91 X=AC(1) Y1", [(2, 3), (1, 4)]),
    "AX": ("G0 AX[X]=5 AX[Y]=IC(1)", [(5, 1)]),
    "inches": ("G70 G0 X1\nG71 X1", [(25.4,), (1,)]),
    "R parameters": ("R1=2 R2=R1*3+1\nG0 X=R2 Y=-R1\nR[R1]=9 X=R2", [(7, -2), (9, -2)]),
    "functions": ("R1=SIN(30) R2=SQRT(16)+POT(3) R3=ATAN2(1,1)\nG0 X=R1 Y=R2 Z=R3", [(0.5, 13, 45)]),
    "DIV MOD ROUND": ("R1=7 DIV 2 R2=7 MOD 4 R3=ROUND(2.5) R4=TRUNC(-2.7)\nG0 X=R1+R4 Y=R2 Z=R3", [(1, 3, 3)]),
    "exponent": ("R1=1.5EX2\nG0 X=R1", [(150,)]),
    "DEF": ("DEF REAL DEPTH=-5, WAY[3]=SET(1,2,3)\nG0 Z=DEPTH X=WAY[2]\nWAY[1]=8 X=WAY[1]", [(3, 0, -5), (8, 0, -5)]),
    "INT rounds": ("DEF INT COUNT\nCOUNT=2.6\nG0 X=COUNT", [(3,)]),
    # "On type conversion from REAL to INT, a fraction >= 0.5 is rounded up ... (same effect as ROUND function)" (840D, Advanced, 1.9).
    "halves of INT": ("DEF INT COUNT=0.5, LIST[4]=SET(1,2,3,4)\nG0 X=COUNT\nCOUNT=2.5\nX=COUNT\nX=ROUND(4.5)\nX=LIST[0.5]\nLIST[2.5]=4.5\nX=LIST[3]",
                      [(1,), (3,), (5,), (2,), (5,)]),
    "strings": ('DEF STRING[10] NAME\nNAME="AB"\nIF NAME=="AB"\nG0 X1\nENDIF\nMSG("at "<<NAME)', [(1,)]),
    "IF ELSE": ("R1=1\nIF R1==2\nG0 X1\nELSE\nG0 X2\nENDIF\nG0 Y1", [(2,), (2, 1)]),
    "IF nested": ("IF 1\nIF 0\nG0 X1\nELSE\nG0 X2\nENDIF\nELSE\nG0 X3\nENDIF", [(2,)]),
    "AND OR NOT": ("R1=5\nIF (R1>2) AND NOT (R1==3) OR 0\nG0 X1\nENDIF", [(1,)]),
    "FOR": ("FOR R1=1 TO 3\nG0 X=R1\nENDFOR\nY=R1", [(1,), (2,), (3,), (3, 4)]),
    "FOR not at all": ("FOR R1=3 TO 1\nG0 X=R1\nENDFOR\nG0 Y1", [(0, 1)]),
    "FOR nested": ("FOR R1=1 TO 2\nFOR R2=1 TO 2\nG0 X=R1 Y=R2\nENDFOR\nENDFOR", [(1, 1), (1, 2), (2, 1), (2, 2)]),
    "WHILE": ("R1=0\nWHILE R1<2\nR1=R1+1\nG0 X=R1\nENDWHILE", [(1,), (2,)]),
    "REPEAT UNTIL": ("R1=0\nREPEAT\nR1=R1+1\nG0 X=R1\nUNTIL R1>=2", [(1,), (2,)]),
    "LOOP": ("R1=0\nLOOP\nR1=R1+1\nG0 X=R1\nIF R1==2 GOTOF AUS\nENDLOOP\nAUS: G0 Y1", [(1,), (2,), (2, 1)]),
    "GOTOB": ("R1=0\nL1_: R1=R1+1\nG0 X=R1\nIF R1<3 GOTOB L1_", [(1,), (2,), (3,)]),
    "GOTO a block number": ("GOTO N30\nN20 G0 X9\nN30 G0 X1", [(1,)]),
    "GOTOC nowhere": ("GOTOC NIRGENDS\nG0 X1", [(1,)]),
    "GOTO by a text": ('DEF STRING[8] ZIEL="ENDE1"\nGOTOF ZIEL\nG0 X9\nENDE1: G0 X1', [(1,)]),
    "GOTO by a text in brackets": ('R1=2\nGOTOF("STEP_"<<R1)\nG0 X9\nSTEP_1: G0 X1\nSTEP_2: G0 X2', [(2,)]),
    "<< makes a text of a value": ('DEF STRING[20] TEXT_1\nR1=1234567\nTEXT_1=<<R1<<"AB"\nG0 X=STRLEN(TEXT_1)\nGOTOF "N"<<R1\nG0 X8\nN1234567 G0 X1', [(9,), (1,)]),
    "GOTO by a text that is joined": ('R1=2\nGOTOF "STEP_" << R1\nG0 X9\nSTEP_1: G0 X1\nSTEP_2: G0 X2', [(2,)]),
    "names like addresses": ("DEF REAL X9_, B2\nDEF INT C3=5\nB2=10\nG0 X=B2 Y=C3\nM30", [(10, 5)]),
    "arguments named like addresses": ("TEIL(3,4)\nM30\nPROC TEIL(REAL A1, REAL B2)\nG0 X=A1 Y=B2\nM17", [(3, 4)]),
    "CASE": ("R1=2\nCASE R1 OF 1 GOTOF A1_ 2 GOTOF A2_ DEFAULT GOTOF A3_\nA1_: G0 X1\nA2_: G0 X2\nA3_: G0 X3", [(2,), (3,)]),
    "CASE default": ("CASE R1 OF 1 GOTOF A1_ DEFAULT GOTOF A3_\nA1_: G0 X1\nA3_: G0 X3", [(3,)]),
    "REPEAT a part": ("G91\nAN: G0 X1\nAUS: Y1\nREPEAT AN AUS P=2", [(1,), (1, 1), (2, 1), (2, 2), (3, 2), (3, 3)]),
    "REPEAT from a label to here": ("G91\nAN: G0 X1\nREPEAT AN P=2", [(1,), (2,), (3,)]),
    "REPEATB": ("G91\nAN: G0 X1\nY1\nREPEATB AN P=2", [(1,), (1, 1), (2, 1), (3, 1)]),
    "ENDPROC": ("TEIL\nG0 X9\nM30\nPROC TEIL\nG0 X5\nENDPROC", [(5,), (9,)]),
    "a subprogram": ("G91\nL10 P3\nG0 Y1\nM30\n%_N_L10_SPF\nG0 X1\nM17", [(1,), (2,), (3,), (3, 1)]),
    "a subprogram of a cycle's name": ("CYCLE82(5,0,2,-10)\nM30\nPROC CYCLE82(REAL A, REAL B, REAL C, REAL D)\nG0 X=A Y=D\nM17", [(5, -10)]),
    "a subprogram of a cycle's name, modal": ("G91\nMCALL CYCLE82\nX1\nX1\nMCALL\nX1\nM30\n%_N_CYCLE82_SPF\nG0 Y1\nY1\nM17", [(1,), (1, 1), (1, 2), (2, 2), (2, 3), (2, 4), (3, 4)]),
    "PROC": ("WEG(3,4)\nM30\nPROC WEG(REAL A, REAL B)\nG0 X=A Y=B\nRET", [(3, 4)]),
    "VAR": ("R1=1\nPLUS(R1)\nG0 X=R1\nM30\nPROC PLUS(VAR REAL WERT)\nWERT=WERT+5\nRET", [(6,)]),
    "an argument left out": ("WEG(,4)\nM30\nPROC WEG(REAL A=7, REAL B)\nG0 X=A Y=B\nM17", [(7, 4)]),
    "variables are a program's own": ("DEF REAL AA=1\nSUB1\nG0 X=AA\nM30\nPROC SUB1\nDEF REAL AA=9\nG0 Y=AA\nRET", [(0, 9), (1, 9)]),
    "SAVE": ("G90 G0 X1\nSUB1\nX1\nM30\nPROC SUB1 SAVE\nG91 X1\nTRANS X50\nRET", [(1,), (2,), (1,)]),
    "fixed points of machine axes": ("G0 X10 Y10 Z10\nG75 FP=1 Z1=0\nG74 X1=0 Y1=0\nM30", [(10, 10, 10), (10, 10, 0), (0, 0, 0)]),
    "two jumps in a block": ("R1=2\nIF R1==1 GOTOF EINS IF R1==2 GOTOF ZWEI\nG0 X9\nEINS: G0 X1\nZWEI: G0 Y2\nM30", [(0, 2)]),
    "axes of the plane": ("DEF AXIS ERSTE\nERSTE=$P_AXN1\nG0 AX[ERSTE]=3\nG18\nERSTE=$P_AXN2\nAX[ERSTE]=4\nAX[$P_AXN3]=5\nM30", [(3,), (4,), (4, 5)]),
    "an array of the caller": ("DEF REAL ORT[2]=SET(1,2)\nEXTERN WEITER(VAR REAL[2], REAL)\nWEITER(ORT,5)\nG0 X=ORT[0] Y=ORT[1]\nM30\n"
                               "PROC WEITER(VAR REAL FELD[2], REAL STUECK)\nFELD[1]=FELD[0]+STUECK\nRET", [(1, 6)]),
    "an array's copy": ("DEF REAL ORT[2]=SET(1,2)\nWEITER(ORT)\nG0 X=ORT[0]\nM30\nPROC WEITER(REAL FELD[2])\nFELD[0]=9\nG0 Y=FELD[0]\nRET", [(0, 9), (1, 9)]),
    "macros": ('DEFINE TASCHE AS G1 X5 F100 ; nothing\nN5 DEFINE HOCH AS G0 Z9\nTASCHE Y3 ; TASCHE\nMSG("HOCH")\nHOCH\nhoch X1', [(5, 3), (5, 3, 9), (1, 3, 9)]),
    "EXTERN": ("EXTERN WEG(REAL)\nWEG(2)\nM30\nPROC WEG(REAL A)\nG0 X=A\nRET", [(2,)]),
    "TRANS": ("TRANS X10 Y5\nG0 X1 Y1\nATRANS X1\nX1\nTRANS\nX1 Y1", [(11, 6), (12, 6), (1, 1)]),
    "a shift of a rotary axis by 0": ("TRANS X10 B=0\nG0 X1\nATRANS C0\nX2", [(11,), (12,)]),
    "the manual's G58 and G59": ("TRANS X10 Y10 Z10\nATRANS X5 Y5\nG0 X0 Y0 Z0\nG58 X20\nX0\nG59 X10 Y10\nX0 Y0\nTRANS\nX0 Y0 Z0", [(15, 15, 10), (25, 15, 10), (30, 20, 10), (0, 0, 0)]),
    "G59 behind ROT": ("ROT RPL=90\nATRANS X5\nG58 X1\nG0 X0 Y0\nG59 Y2\nX0 Y0", [(1, 5), (1, 2)]),
    "parts of $P_PFRAME": ("TRANS X10\nATRANS X5\n$P_PFRAME[X,TR]=20\nG0 X0\n$P_PFRAME[X,FI]=1\nX0", [(25,), (21,)]),
    "ROT": ("ROT RPL=90\nG0 X5\nY2\nROT\nX0 Y0", [(0, 5), (-2, 5), (0, 0)]),
    "ROT about axes": ("ROT X90\nG0 Y5\nZ2", [(0, 0, 5), (0, -2, 5)]),
    "ROT Z then Y": ("ROT Y90 Z90\nG0 X5\nY3", [(0, 0, -5), (-3, 0, -5)]),
    "AROT": ("TRANS X10\nAROT Z90\nG0 X5 Y1", [(9, 5)]),
    "SCALE MIRROR": ("SCALE X2 Y2\nG0 X1 Y1\nMIRROR X0\nX1 Y1\nAMIRROR Y0\nX1 Y1", [(2, 2), (-1, 1), (-1, -1)]),
    "the manual's row of pockets": ("TRANS X50 Y50\nG0 X0\nTRANS X50 Y10\nX0\nTRANS X10 Y50\nX0 Y0", [(50, 0), (10, 50)]),
    "origins": ("$P_UIFR[1]=CTRANS(X,10,Y,20)\n$P_UIFR[5]=CTRANS(X,100)\nG54 G0 X1 Y1\nG505 X1 Y1\nG500 X1 Y1", [(11, 21), (101, 1), (1, 1)]),
    "many origins": ("$P_UIFR[99]=CTRANS(X,10)\n$P_UIFR[57]=CTRANS(X,20)\n$P_UIFR[58]=CTRANS(X,30)\nG599 G0 X1\nG557 X1\nG558 X1\nG500 X1", [(11,), (21,), (31,), (1,)]),
    "SUPA": ("$P_UIFR[1]=CTRANS(X,10)\nG54 TRANS X5\nG0 X1\nSUPA X1\nG153 X2\nX1", [(16,), (1,), (2,), (16,)]),
    "polar": ("G111 X10 Y10\nG0 AP=0 RP=5\nAP=90\nRP=10", [(15, 10), (10, 15), (10, 20)]),
    "polar incremental": ("G111 X0 Y0\nG0 AP=0 RP=10\nAP=IC(60)\nAP=IC(30)", [(10, 0), (5, 8.660254), (0, 10)]),
    "pole from here": ("G0 X5 Y5\nG110 X1 Y0\nAP=90 RP=2\nG112 X0 Y10\nAP=0 RP=1", [(5, 5), (6, 7), (7, 15)]),
    "CYCLE81": ("G0 X5 Z20\nCYCLE81(20,0,2,-15)", [(5, 0, 20), (5, 0, 2), (5, 0, -15), (5, 0, 20)]),
    "CYCLE82": ("G0 Z20\nCYCLE82(110,102,4,75,,2)", [(0, 0, 20), (0, 0, 106), (0, 0, 75), (0, 0, 110)]),
    "CYCLE83 with MDEP": ("CYCLE83(10,0,1,-6.5,,-2,,0.5,,,1,0,,1,0.25)",
                          [(0, 0, z) for z in (1, -2, -1.75, -3.5, -3.25, -4.5, -4.25, -5.5, -5.25, -6.5, 10)]),
    "CYCLE83 with DIS1": ("CYCLE83(10,0,1,-4,,-2,,,,,1,1,,,,,0.2)", [(0, 0, z) for z in (1, -2, 1, -1.8, -4, 10)]),
    "CYCLE84 breaks chips": ("CYCLE84(10,0,2,-8,,0,3,,1,0,200,200,0,1,,1,3,0.5)",
                             [(0, 0, z) for z in (2, -3, -2.5, -6, -5.5, -8, 2, 10)]),
    "CYCLE84 clears chips": ("CYCLE84(10,0,2,-8,,0,3,,1,0,200,200,0,1,,2,5)", [(0, 0, z) for z in (2, -5, 2, -8, 2, 10)]),
    "CYCLE87": ("CYCLE87(10,0,2,-10,,3)", [(0, 0, z) for z in (2, -10, 10)]),
    "CYCLE88": ("CYCLE88(10,0,2,,10,0,4)", [(0, 0, z) for z in (2, -10, 10)]),
    "CYCLE89": ("F100\nCYCLE89(10,0,2,-10,,1)", [(0, 0, z) for z in (2, -10, 2, 10)]),
    "GOTOS": ("DEF REAL ORT=5\nR1=R1+1\nG0 X=R1\nIF R1<3 GOTOS\nY1", [(1,), (2,), (3,), (3, 1)]),
    "CALL BLOCK": ("CALL BLOCK ANF TO ENDE\nG0 Y1\nM30\nANF: G0 X1\nX2\nENDE: X3\nX4", [(1,), (2,), (3,), (3, 1)]),
    "paths of calls": ('DEF STRING[20] WO="/_N_SPF_DIR/_N_UP1_SPF"\nCALL "/_N_SPF_DIR/_N_UP1_SPF"\nEXTCALL("/_N_EXT_DIR/_N_UP1_SPF")\nCALL WO\nPCALL L7\nM30\n%_N_UP1_SPF\nG91 G0 X1\nM17\n%_N_L7_SPF\nG0 Y1\nM17', [(1,), (2,), (3,), (3, 1)]),
    # Programs of a grinding machine join a name and "_SPF".
    "a name with its suffix": ('DEF STRING[20] WO="UP1"<<"_SPF"\nCALL WO\nEXTCALL "UP1_SPF"\nM30\n%_N_UP1_SPF\nG91 G0 X1\nM17', [(1,), (2,)]),
    "EXTCALL": ('EXTCALL "UP1"\nEXTCALL("/_N_WKS_DIR/UP1.SPF")\nM30\n%_N_UP1_SPF\nG91 G0 X1\nM17', [(1,), (2,)]),
    "CYCLE83 clears": (
        "CYCLE83(10,0,1,-25,,-10,,2,,,1,1)",
        [(0, 0, z) for z in (1, -10, 1, -9.4, -18, 1, -17.4, -24, 1, -23.4, -25, 10)],
    ),
    # Down to 30 mm the distance ahead is 0.6; beyond, a fiftieth of the way from RFP + SDIS, and 7 at most.
    "CYCLE83 in a deep hole": ("CYCLE83(10,0,1,-500,,-240,,9,,,1,1)",
                               [(0, 0, z) for z in (1, -240, 1, -235.18, -471, 1, -464, -500, 10)]),
    "CYCLE83 with steps in percent": ("F100\nCYCLE83(10,0,1,-20,,-10,,50,0,0,50,1,0,2,0,0,1,0,1,12221112)",
                                      [(0, 0, z) for z in (1, -10, 1, -9, -15, 1, -14, -17.5, 1, -16.5, -19.5, 1, -18.5, -20, 10)]),
    "CYCLE83 with distances": ("CYCLE83(10,0,1,-50,12,-30,6,2,0,0,1,1,0,2,0,0,5,0,1,1110011)",
                               [(0, 0, z) for z in (1, -6, 1, -5.4, -10, 1, -9.4, -12, 10)]),
    "CYCLE83 in inches": ("G70\nCYCLE83(1,0,0.1,-2,,-1)", [(0, 0, z) for z in (2.54, -25.4, -24.4, -50.8, 25.4)]),
    "CYCLE85 with a distance": ("F100\nCYCLE85(10,0,2,-8,5,0,100,100,0,1,1)", [(0, 0, z) for z in (2, -5, 2, 10)]),
    "CYCLE82 with a distance": ("CYCLE82(10,0,2,-8,5,0,0,1,11)", [(0, 0, z) for z in (2, -5, 10)]),
    "CYCLE83 breaks": ("CYCLE83(10,0,1,-15,,,10,5,,,,0)", [(0, 0, z) for z in (1, -10, -9, -15, 10)]),
    "CYCLE84": ("S100\nCYCLE84(10,0,2,-10,,,5,,1.5,,200,400)", [(0, 0, z) for z in (2, -10, 2, 10)]),
    "CYCLE84 with a distance": ('S100\nCYCLE84(10,0,2,-10,7,,5,,1.5,,200,400,,1,,,,,"","","",0,1,1001001)', [(0, 0, z) for z in (2, -7, 2, 10)]),
    "CYCLE840": ("S100 M3\nCYCLE840(10,0,2,-10,,0,4,3,0,,1)", [(0, 0, z) for z in (2, -10, 2, 10)]),
    "CYCLE85": ("CYCLE85(10,0,2,-10,,0,100,200)", [(0, 0, z) for z in (2, -10, 2, 10)]),
    "CYCLE86": (
        "G0 X5\nCYCLE86(10,0,2,-10,,0,3,-1,0,1)",
        [(5, 0, 0), (5, 0, 2), (5, 0, -10), (4, 0, -9), (4, 0, 10), (5, 0, 10)],
    ),
    "MCALL": ("MCALL CYCLE81(10,0,2,-5)\nG0 X1\nMCALL\nX2", [(1,), (1, 0, 2), (1, 0, -5), (1, 0, 10), (2, 0, 10)]),
    "MCALL a subprogram": ("MCALL LOCH\nG0 X1\nX2\nMCALL\nX3\nM30\nPROC LOCH\nG91 Y1\nG90\nRET", [(1,), (1, 1), (2, 1), (2, 2), (3, 2)]),
    "HOLES1": ("MCALL CYCLE81(10,0,2,-5)\nHOLES1(10,0,0,5,10,2)\nMCALL",
               [(15,), (15, 0, 2), (15, 0, -5), (15, 0, 10), (25, 0, 10), (25, 0, 2), (25, 0, -5), (25, 0, 10)]),
    "HOLES2": ("MCALL CYCLE81(10,0,2,-5)\nHOLES2(0,0,10,0,90,2)\nMCALL",
               [(10,), (10, 0, 2), (10, 0, -5), (10, 0, 10), (0, 10, 10), (0, 10, 2), (0, 10, -5), (0, 10, 10)]),
    "CYCLE800": ("CYCLE800(0,\"TC\",0,57,10,0,0,0,90,0,0,0,0,1)\nG0 X1 Z5\nCYCLE800()\nX0 Z0", [(15, 0, -1), (0, 0, 0)]),
    "RND": ("G1 X10 F100 RND=2\nY10", [(8,), (10, 2), (10, 10)]),
    "CHR": ("G1 X10 F100 CHR=2\nY10", [(8,), (10, 2), (10, 10)]),
    "CHF": (f"G1 X10 F100 CHF={2 * math.sqrt(2)}\nY10", [(8,), (10, 2), (10, 10)]),
    "RNDM": ("RNDM=2 G1 X10 F100\nY10\nRNDM=0 X0", [(8,), (10, 2), (10, 8), (8, 10), (0, 10)]),
    "CR": ("F100 G2 X10 Y10 CR=10\nG3 X20 Y20 CR=10", [(10, 10), (20, 20)]),
    "AR with a centre": ("F100 G3 I10 J0 AR=90", [(10, -10)]),
    "AR with an end": ("F100 G3 X20 Y0 AR=180", [(20, 0)]),
    "CIP": ("F100 CIP X20 Y0 I1=10 J1=-10", [(20, 0)]),
    "CT": ("F100 G1 X10\nCT X20 Y10", [(10,), (20, 10)]),
    "polar arc": ("G111 X0 Y0\nF100 G0 X10\nG3 AP=90 RP=10", [(10,), (0, 10)]),
    "dwell and speed": ("S100 M3\nG4 F0.5\nG4 S30\nG0 X1", [(1,)]),
    "exact stop": ("G60 G1 X1 F100\nG64 X2\nG9 X3\nG641 ADIS=0.5 X4\nG642 X5\nG645 X6", [(x,) for x in range(1, 7)]),
}  # fmt: skip


def ends(out: Any) -> list[tuple[float, ...]]:
    """Return where motions end, X Y Z, zeros at the end left out but for X."""
    found = []
    for row in out.path.end[out.path.kind < 3]:
        point = [round(float(v), 6) + 0.0 for v in row[:3]]
        while len(point) > 1 and point[-1] == 0.0:
            point.pop()
        found.append(tuple(point))
    return found


def trimmed(points: list[tuple[float, ...]]) -> list[tuple[float, ...]]:
    """Return expected points in the form of `ends`."""
    found = []
    for point in points:
        row = [float(v) for v in point]
        while len(row) > 1 and row[-1] == 0.0:
            row.pop()
        found.append(tuple(row))
    return found


@pytest.mark.parametrize("name", [name for name, (_, points) in MOTIONS.items() if points])
def test_motions(run: Any, name: str) -> None:
    text, points = MOTIONS[name]
    lines = text if "M30" in text else f"{text}\nM30"
    if "F" not in text or "CYCLE" in text:
        lines = f"F100\n{lines}"
    out = run(lines, dialect="sinumerik")
    assert out.errors == []
    assert ends(out) == trimmed(points)


def arcs(out: Any) -> list[tuple[float, float, float]]:
    """Return centre and sweep (degrees, positive counter-clockwise) of the arcs."""
    table: ArcTable = out.path.arcs
    return [
        (round(float(c[0]), 6), round(float(c[1]), 6), round(math.degrees(float(s)), 4))
        for c, s in zip(table.centre, table.sweep * table.normal[:, 2], strict=True)
    ]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("G2 X10 Y10 CR=10", (10, 0, -90)),
        ("G2 X10 Y10 CR=-10", (0, 10, -270)),
        ("G3 X10 Y10 I0 J10", (0, 10, 90)),
        ("G2 X10 Y10 I=AC(10) J=AC(0)", (10, 0, -90)),
        ("G3 X0 Y0 I10 J0 TURN=1", (10, 0, 720)),
        ("G3 X20 Y0 AR=180", (10, 0, 180)),
        ("G2 I10 J0 AR=90", (10, 0, -90)),
        ("CIP X20 Y0 I1=10 J1=-10", (10, 0, 180)),
        ("CIP X20 Y0 I1=10 J1=10", (10, 0, -180)),
        ("MIRROR X0\nG2 X10 Y10 CR=10", (-10, 0, 90)),
        ("ROT RPL=90\nG2 X10 Y10 CR=10", (0, 10, -90)),
        ("SCALE X2 Y2\nG2 X10 Y10 CR=10", (20, 0, -90)),
    ],
)
def test_arcs(run: Any, text: str, expected: tuple[float, float, float]) -> None:
    out = run(f"F100\n{text}\nM30", dialect="sinumerik")
    assert out.errors == []
    assert arcs(out) == [expected]


def test_rotary_axes_go_the_way_that_is_asked_for(run: Any) -> None:
    out = run("G0 A350\nA=DC(10)\nA=ACN(5)\nA=ACP(0)\nA=IC(90)\nM30", dialect="sinumerik")
    angles = np.degrees(out.path.end[out.path.kind < 3][:, out.axes.index("A")])
    assert angles == pytest.approx([350, 370, 365, 720, 810])


def table_of(tmp_path: Path) -> Path:
    table = tmp_path / "tools.tbl"
    table.write_text("T1 P1 Z10 D4\nT2 P2 Z20 D6\n")
    return table


def test_tools_and_compensation(run: Any, tmp_path: Path) -> None:
    """The length counts from M6 on; G41 takes the radius of 2 and leads straight to beside the first point; G451 goes to where the paths
    cross, G450 around."""
    text = "T1 M6\nG0 X0 Y0 Z5\nG41 G1 X10 F100\n{}Y10\nX20\nY0\nG40 X0\nD0 Z5\nM30"
    table = table_of(tmp_path)
    around = ends(run(text.format("G450 "), dialect="sinumerik", tool_table=table))
    assert around == trimmed(
        [
            (0, 0, 15),
            (8, 0, 15),
            (8, 10, 15),
            (10, 12, 15),
            (20, 12, 15),
            (22, 10, 15),
            (22, 0, 15),
            (0, 0, 15),
            (0, 0, 5),
        ]
    )
    across = ends(run(text.format("G451 "), dialect="sinumerik", tool_table=table))
    assert across == trimmed(
        [(0, 0, 15), (8, 0, 15), (8, 12, 15), (22, 12, 15), (22, 0, 15), (0, 0, 15), (0, 0, 5)]
    )


@pytest.mark.parametrize(
    ("entry", "first"),
    [("X10 Y5", (10, 7)), ("X10 Y-5", (10, -3)), ("X-10 Y0", (-10, 2)), ("X10 Y0", (10, 2))],
)
def test_the_way_to_a_contour_is_straight(
    run: Any, tmp_path: Path, entry: str, first: tuple[float, float]
) -> None:
    """NORM: straight to beside the first point, square to the contour there, whatever the angle; the contour goes along X, the radius is 2."""
    text = f"T1 M6\nG0 X0 Y0\nG41 G1 {entry} F100\nX30\nG40 Y30\nM30"
    assert ends(run(text, dialect="sinumerik", tool_table=table_of(tmp_path)))[0][:2] == first


def test_other_ways_to_a_contour_are_told(run: Any, tmp_path: Path) -> None:
    text = "T1 M6\nG0 X0 Y0\nKONT G41 G1 X10 F100\nX30\nG40 Y30\nM30"
    out = run(text, dialect="sinumerik", tool_table=table_of(tmp_path))
    assert [(d.code, d.span.line) for d in out.diagnostics if d.severity == "warning"] == [
        ("comp-approach", 3)
    ]


@pytest.mark.parametrize("kind", ["ASPLINE", "CSPLINE"])
def test_splines_go_through_their_points(run: Any, kind: str) -> None:
    """On points of a line, both are the line."""
    out = run(f"F100\n{kind} X1 Y1\nX2 Y2\nX4 Y4\nG1 X5 Y5\nM30", dialect="sinumerik")
    assert out.errors == []
    nurbs = out.path.nurbs
    assert len(out.path.end[out.path.kind == 2]) == 1
    points = np.asarray(nurbs.control_points)[:, :2]
    assert points[:, 0] == pytest.approx(points[:, 1])
    assert (points[0].tolist(), points[-1].tolist()) == ([0, 0], [4, 4])


def test_bspline_has_its_points(run: Any) -> None:
    out = run("F100\nBSPLINE X1 Y2 PW=2\nX2 Y0\nX4 Y4\nG1 X5\nM30", dialect="sinumerik")
    assert out.errors == []
    assert np.asarray(out.path.nurbs.weights).tolist() == [1, 2, 1, 1]


def test_polynomial(run: Any) -> None:
    """X = 2 p + p², Y = 3 p² - p³ over 0 to 1, as a Bézier curve of degree 3: the example's end is X3 Y2."""
    out = run("F100\nPOLY PO[X]=(3,1) PO[Y]=(2,3,-1) PL=1\nM30", dialect="sinumerik")
    assert out.errors == []
    points = np.asarray(out.path.nurbs.control_points)[:, :2]
    expected = [(0, 0), (2 / 3, 0), (5 / 3, 1), (3, 2)]
    assert points == pytest.approx(np.array(expected))


def test_an_arc_in_a_turned_plane_is_a_spline_of_the_same_points(run: Any) -> None:
    out = run("F100\nROT X90\nG3 X0 Y20 I0 J10\nM30", dialect="sinumerik")
    assert out.errors == []
    points = np.asarray(out.path.nurbs.control_points)
    assert points[:, 1] == pytest.approx(0.0)
    assert points[-1, 2] == pytest.approx(20.0)


def test_cip_in_space_is_the_arc_of_a_turned_plane(run: Any) -> None:
    """Through (10, 0, 10) to (0, 0, 20): the half circle about (0, 0, 10) that ROT X90 makes of G3 in G17."""
    half = run("F100\nROT X90\nG3 X0 Y20 I0 J10\nM30", dialect="sinumerik")
    for words in (
        "G17\nCIP X0 Y0 Z20 I1=10 J1=0 K1=10",
        "G19\nG91\nCIP Z20 I1=10 K1=10",
        "TRANS Y0\nCIP Z20 I1=10 K1=10",
    ):
        out = run(f"F100\n{words}\nM30", dialect="sinumerik")
        assert out.errors == []
        points, expected = (np.asarray(one.path.nurbs.control_points)[:, :3] for one in (out, half))
        assert points == pytest.approx(expected, abs=1e-9)


def test_cip_in_space_goes_through_its_point(run: Any) -> None:
    """The radius of the circle through three points, and the feed in the direction in which it ends."""
    out = run("F100\nCIP X10 Y0 Z5 I1=5 J1=5 K1=12\nCT X20 Y0\nM30", dialect="sinumerik")
    a, b, c = (np.array(p, dtype=float) for p in ((0, 0, 0), (5, 5, 12), (10, 0, 5)))
    normal = np.cross(b - a, c - a)
    points = np.asarray(out.path.nurbs.control_points)[:, :3]
    assert points @ normal == pytest.approx(0.0, abs=1e-6 * np.linalg.norm(normal))
    assert points[-1] == pytest.approx(c)


@pytest.mark.parametrize(("mode", "wait"), [(0, 0.5), (1, 0.5), (2, 0.06)])
def test_modes_of_a_cycle_choose_units(run: Any, mode: int, wait: float) -> None:
    """DTB of 0.5 is seconds or half a turn; FRF is a factor, or a percentage."""
    drill = f"S500 M3 F100\nCYCLE82(10,0,2,-8,,0.5,0,1,{mode}2)\nM30"
    events = run(drill, dialect="sinumerik").path.events
    assert [event.dwell_s for event in events if event.name == "dwell"] == pytest.approx([wait])
    for factor, digit in ((0.5, 0), (50, 1)):
        out = run(
            f"F100\nCYCLE83(10,0,2,-8,,-4,,,,,{factor},1,,,,,,,,{digit}0000000)\nM30", dialect="sinumerik"
        )
        cuts = out.path.feed_mode != FeedMode.RAPID
        assert out.path.feed[cuts] * 60.0 == pytest.approx([50, 100])


@pytest.mark.parametrize(
    ("pitch", "mode", "left"),
    [(1, 0, False), (-1, 0, True), (1, 1001002, False), (1, 1002002, True), (-1, 1001002, False)],
)
def test_the_hand_of_a_tap(calls: Any, pitch: int, mode: int, left: bool) -> None:
    """The sign of PIT, or the fourth digit of AMODE (1 right, 2 left), as posts write it for taps; out it turns the other way."""
    tap = f'G0 Z10\nCYCLE84(10,0,2,-8,,0,5,,{pitch},0,200,200,0,1,0,0,,1.4,"","","",0,0,{mode})\nM30'
    turns = [
        call.split("_")[2].split("(")[0]
        for call in calls(tap, dialect="sinumerik")
        if call.startswith("START_SPINDLE")
    ]
    assert turns == (["COUNTERCLOCKWISE", "CLOCKWISE"] if left else ["CLOCKWISE", "COUNTERCLOCKWISE"])


def test_it_is_recognised(run: Any) -> None:
    out = run('N10 G17 G54\nN20 T="MILL 10" D1\nN30 M6\nN40 G0 X1\nN50 CYCLE81(10,0,2,-5)\nN60 M30')
    assert any(d.message.startswith("read as sinumerik") for d in out.diagnostics)
    assert out.errors == [("feed-missing", 5, 1)]


#: Program, and code, line and column of its fault.
WRONG: dict[str, tuple[str, tuple[str, int, int]]] = {
    "no value": ("G1 X=", ("syntax", 1, 6)),
    "a sign": ("G1 X10 = 5", ("variable-unknown", 1, 4)),
    "an open bracket": ("X=(1+2", ("syntax", 1, 7)),
    "a synchronous action": ("WHEN $AA_IW[X]>3 DO M3\nG0 X1", ("not-read", 1, 1)),
    "a synchronous action by its number": ("N5 ID=1 WHENEVER $AA_IW[X]>3 DO $AC_OVR=50", ("not-read", 1, 4)),
    "an unknown name": ("G1 X=TIEFE F100", ("variable-unknown", 1, 6)),
    "an unknown word": ("TIEFE=5", ("variable-unknown", 1, 1)),
    "an unknown subprogram": ("G0 X1\nTASCHE", ("sub-missing", 2, 1)),
    "an unknown cycle": ("CYCLE72(1)", ("not-read", 1, 1)),
    "an unknown function": ("R1=SINH(1)", ("function-unknown", 1, 4)),
    "a root": ("R1=SQRT(-1)", ("domain", 1, 4)),
    "an arc sine": ("R1=ASIN(2)", ("domain", 1, 4)),
    "too many arguments": ("R1=SIN(1,2)", ("function-arguments", 1, 4)),
    "division by zero": ("R1=1/0", ("division-by-zero", 1, 1)),
    "a text for a number": ('R1="A"', ("value-kind", 1, 1)),
    "an index": ("DEF REAL AB[2]\nAB[2]=1", ("variable-index", 2, 1)),
    "no index": ("DEF REAL AB[2]\nAB=1", ("variable-index", 2, 1)),
    "a name twice": ("DEF REAL AB\nDEF INT AB", ("variable-name", 2, 9)),
    "an R of a fraction": ("R[1.5]=2", ("parameter-number", 1, 1)),
    "ENDIF alone": ("ENDIF", ("flow-unmatched", 1, 1)),
    "IF open": ("IF 1\nG0 X1", ("flow-unmatched", 1, 1)),
    "FOR closed by ENDWHILE": ("FOR R1=1 TO 2\nENDWHILE\nENDFOR", ("flow-unmatched", 2, 1)),
    "GOTOF above": ("AB: G0 X1\nGOTOF AB", ("label-missing", 2, 1)),
    "GOTOB nowhere": ("GOTOB AB", ("label-missing", 1, 1)),
    "REPEAT nowhere": ("REPEAT AB P=2", ("label-missing", 1, 1)),
    "too many values": ("WEG(1,2)\nM30\nPROC WEG(REAL A)\nRET", ("sub-arguments", 1, 1)),
    "a second fixed point": ("G0 Z5\nG75 FP=2 Z1=0", ("not-read", 2, 5)),
    "no axis": ("DEF AXIS ERSTE\nG0 AX[ERSTE]=3", ("variable-unknown", 2, 4)),
    "no array": ("DEF REAL ORT\nWEG(ORT)\nM30\nPROC WEG(VAR REAL A[3])\nRET", ("sub-arguments", 2, 1)),
    "a value for VAR": ("WEG(1+1)\nM30\nPROC WEG(VAR REAL A)\nRET", ("sub-arguments", 1, 1)),
    "no feed": ("G1 X1", ("feed-missing", 1, 1)),
    "no centre": ("F100 G2 X10", ("arc-centre", 1, 6)),
    "a radius too small": ("F100 G2 X10 CR=4", ("arc-radius", 1, 13)),
    "a full circle by CR": ("F100 G2 X0 CR=4", ("arc-radius", 1, 12)),
    "AR too large": ("F100 G2 X10 AR=400", ("arc-angle", 1, 13)),
    "CIP in a line": ("F100 CIP X10 I1=5", ("arc-centre", 1, 6)),
    "CT at the beginning": ("F100 CT X10 Y1", ("arc-tangent", 1, 6)),
    "TURN": ("F100 G2 X10 CR=5 TURN=0.5", ("arc-turns", 1, 18)),
    "a centre beside the plane": ("F100 G2 X10 I5 K5", ("arc-plane", 1, 16)),
    "polar and axis": ("G0 X1 AP=0 RP=5", ("polar-words", 1, 7)),
    "a negative radius": ("G0 AP=0 RP=-5", ("polar-words", 1, 9)),
    "a word of nothing": ("G0 X1 CR=5", ("unused-word", 1, 7)),
    "a word twice": ("G0 X1 X2", ("repeated-word", 1, 4)),
    # Alarm 12060: the same G group twice in one block.
    "two motions": ("G1 G0 X1 F100", ("modal-conflict", 1, 4)),
    "absolute and increments": ("G90 X1 G91 Y2", ("modal-conflict", 1, 8)),
    "two origins": ("G54 G17 G55 X1", ("modal-conflict", 1, 9)),
    "a code": ("G777 X1", ("unknown-code", 1, 1)),
    "a code that is not read": ("G7 X1", ("not-read", 1, 1)),
    "no depth": ("F100\nCYCLE81(10,0,2)", ("cycle-depth", 2, 1)),
    "a depth above": ("F100\nCYCLE81(10,0,2,5)", ("cycle-depth", 2, 1)),
    "a retraction below": ("F100\nCYCLE81(1,0,2,-5)", ("cycle-depth", 2, 1)),
    "no first depth": ("F100\nCYCLE83(10,0,2,-5)", ("cycle-infeed", 2, 1)),
    "no lead": ("S100\nCYCLE84(10,0,2,-5,,,3,,,,100)", ("pitch-missing", 2, 1)),
    "holes without a cycle": ("HOLES2(0,0,10,0,0,4)", ("cycle-missing", 1, 1)),
    "a scale of nothing": ("SCALE X0", ("scale-missing", 1, 1)),
    "RPL beside a turn in space": ("ROT X10 RPL=20", ("unused-word", 1, 9)),
    "CIP along a line in space": ("F100 CIP X10 Y0 Z10 I1=5 K1=5", ("arc-centre", 1, 6)),
    "CIP beyond all numbers": ("F100 CIP X=1EX200 Y0 Z10 I1=5 K1=5", ("arc-centre", 1, 6)),
    "ROTS of three angles": ("ROTS X10 Y20 Z30", ("not-read", 1, 1)),
    "a part of another program": ('CALL "UP1" BLOCK ANF TO ENDE', ("not-read", 1, 12)),
    "CALL BLOCK of no label": ("CALL BLOCK ANF TO ENDE", ("label-missing", 1, 1)),
    "the speed by another axis": ("G96 S200 M4 SCC[Z]", ("not-read", 1, 13)),
    "ISOCALL": ("ISOCALL L100", ("not-read", 1, 1)),
    "a table of a curve": ("CTABDEF(X,Z,1,0)", ("not-read", 1, 1)),
    "PRESETON": ("PRESETON(X)", ("sub-arguments", 1, 1)),
    "GOTOF without a label": ("GOTOF", ("syntax", 1, 6)),
    "CALL of no text": ("DEF REAL WO=1\nCALL WO", ("sub-missing", 2, 1)),
    "G58 of a rotary axis": ("G58 A5", ("not-read", 1, 1)),
    "a frame of a rotary axis": ("TRANS A5", ("not-read", 1, 1)),
    "a mirrored rotary axis": ("MIRROR A0", ("not-read", 1, 1)),
    "an inclined axis": ("TRAANG(45)", ("not-read", 1, 1)),
    "a lead in inches": ("CYCLE84(10,0,2,-8,,0,3,,1,0,200,200,0,3)", ("not-read", 1, 1)),
    "another depth of a drill": ("CYCLE81(10,0,2,-8,,0,20)", ("not-read", 1, 1)),
    "another first depth": ("CYCLE83(10,0,2,-8,,-4,,,,,,,,,,,,1)", ("not-read", 1, 1)),
    "a mode of a cycle": ("CYCLE83(10,0,2,-8,,-4,,,,,,,,,,,,,,3)", ("not-read", 1, 1)),
    "a depth that its mode chooses": ("CYCLE81(10,0,2,-8,,0,0,0,1)", ("cycle-depth", 1, 1)),
    "a plane that a mode chooses": ("CYCLE86(10,0,2,-8,,0,3,0,0,0,0,0,2,10)", ("cycle-plane", 1, 1)),
    "a lift that is not read": ("CYCLE86(10,0,2,-8,,0,3,0,0,0,0,1)", ("not-read", 1, 1)),
    "a mode of a tap": ('CYCLE84(10,0,2,-8,,0,3,,1,0,200,200,,1,,,,,"","","",0,1,3)', ("not-read", 1, 1)),
    "a hole along X": ("CYCLE84(10,0,2,-8,,0,3,,1,0,200,200,1)", ("not-read", 1, 1)),
    "a parameter beyond the mode": ("CYCLE82(10,0,2,-8,,0,0,1,12,1)", ("not-read", 1, 1)),
    "a face of corners": ("F100\nCYCLE61(20,0,2,-4,5,0,30,20,2,100,0,500,31,0,1,1010)", ("not-read", 2, 1)),
    "a face that neither roughs nor finishes": ("F100\nT1 M6\nCYCLE71(20,0,2,-4,0,0,30,20,0,2,4,0,0,500,33,0)", ("not-read", 3, 1)),
    "a spigot with a chamfer": ("F100\nCYCLE77(20,0,2,-4,,20,50,10,2,0,0,500,100,0,5,26,1)", ("not-read", 2, 1)),
    "an edge alone": ("F100\nPOCKET4(20,0,2,-4,10,0,0,2,0,0,500,100,0,4)", ("not-read", 2, 1)),
    "a pocket that is cut in part": ("F100\nPOCKET3(20,0,2,-4,30,20,5,0,0,0,2,0,0,500,100,0,1,,10,5)", ("not-read", 2, 1)),
    "a slot on a cylinder": ("TRACYL(40,1,2)", ("not-read", 1, 1)),
    "diameters": ("G18 DIAMCYCOF", ("not-read", 1, 5)),
    "a step of ShopMill": ("E_FACE(1,2)", ("not-read", 1, 1)),
    "a spindle that does not turn": ("CYCLE87(10,0,2,-10)", ("cycle-spindle", 1, 1)),
    "dwell of nothing": ("G4", ("dwell-missing", 1, 1)),
    "DC of a straight axis": ("G0 X=DC(5)", ("axis-mode", 1, 4)),
    "endless": ("WHILE 1==1\nR1=1\nENDWHILE", ("too-many-steps", 3, 1)),
    "recursion": ("AB1\nM30\nPROC AB1\nAB1\nRET", ("call-depth", 4, 1)),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_named_where_it_stands(run: Any, name: str) -> None:
    text, expected = WRONG[name]
    out = run(text if "M30" in text else f"{text}\nM30", dialect="sinumerik", max_steps=5000)
    assert out.errors[:1] == [expected]
    fault = next(d for d in out.diagnostics if d.severity == "error")
    assert fault.hint


@pytest.mark.parametrize(
    ("cycle", "reach"),
    [
        ("POCKET3(20,0,2,-4,30,20,5,50,10,0,2,0,0,500,100,0,1)", (37, 63, 2, 18)),
        ("POCKET3(20,0,2,-4,30,20,5,50,10,90,2,0,0,500,100,0,1)", (42, 58, -3, 23)),
        ("POCKET3(20,0,2,-4,30,20,5,50,10,0,2,1,0,500,100,0,1)", (38, 62, 3, 17)),
        ("POCKET4(20,0,2,-4,10,50,10,2,0,0,500,100,0,1)", (42, 58, 2, 18)),
        ("SLOT1(20,0,2,-4,,1,30,4,0,0,10,0,0,100,500,2,0,0,0)", (12, 38, 0, 0)),
        ("LONGHOLE(20,0,2,-4,,1,30,0,0,10,0,0,100,500,2)", (12, 38, 0, 0)),
        # Rows 4 apart, the last one 2 within the side; each goes 2 beyond the ends.
        ("CYCLE71(20,0,2,-4,0,0,30,20,0,2,4,0,0,500,31,0)", (-2, 32, 2, 18)),
        ("CYCLE71(20,0,2,-4,0,0,30,20,0,2,4,3,0,500,31,0)", (-5, 35, 2, 18)),
        ("CYCLE71(20,0,2,-4,0,0,30,20,0,2,4,0,0,500,11,0)", (-2, 32, 2, 18)),
        ("CYCLE71(20,0,2,-4,0,0,30,20,90,2,4,0,0,500,31,0)", (-18, -2, -2, 32)),
        # Along Y: eight rows 3.75 apart.
        ("CYCLE71(20,0,2,-4,0,0,30,20,0,2,4,0,0,500,41,0)", (1.75, 28, -2, 22)),
        ("CYCLE71(20,0,2,-4,0,0,-30,-20,0,2,4,0,0,500,31,0)", (-32, 2, -18, -2)),
        ("CYCLE61(20,0,2,-4,0,0,30,20,2,100,0,500,31,0,1,10)", (-2, 32, 2, 18)),
        ("CYCLE61(20,0,2,4,0,0,30,20,2,4,0,500,31,0,1,1)", (-2, 32, 2, 18)),
        # From a corner at 0 the opposite one's coordinates are the sides.
        ("CYCLE61(20,0,2,-4,0,0,30,20,2,100,0,500,31,0,1,11010)", (-2, 32, 2, 18)),
        # Beside the wall by the radius, and from X+ by a diameter and the clearance beyond the blank.
        ("CYCLE76(20,0,2,-4,,30,20,5,50,10,0,2,0,0,500,100,0,1)", (33, 71, -2, 22)),
        ("CYCLE77(20,0,2,-4,,20,50,10,2,0,0,500,100,0,1,26)", (38, 69, -2, 22)),
        ("CYCLE77(20,0,2,-4,,20,50,10,2,1,0,500,100,0,1,26)", (37, 69, -3, 23)),
        # Three loops, 3.2 apart.
        ("CYCLE77(20,0,2,-4,,20,50,10,2,0,0,500,100,0,1,36)", (31.6, 74, -8.4, 28.4)),
    ],
)
def test_pockets_reach_their_wall(run: Any, tmp_path: Path, cycle: str, reach: tuple[float, ...]) -> None:
    """The tool's centre stays its radius of 2, and the allowance, within the wall; the depth of 4 is cut in two levels."""
    out = run(f"T1 M6\nF100\n{cycle}\nM30", dialect="sinumerik", tool_table=table_of(tmp_path))
    assert out.errors == []
    points = out.path.end[out.path.kind < 3][:, :3]
    cuts = points[points[:, 2] < 8.5]
    assert sorted({round(float(z), 6) for z in cuts[:, 2]}) == [6, 8]
    found = (cuts[:, 0].min(), cuts[:, 0].max(), cuts[:, 1].min(), cuts[:, 1].max())
    assert found == pytest.approx(reach)


def test_a_pocket_narrower_than_the_tool_is_refused(run: Any, tmp_path: Path) -> None:
    out = run(
        "T1 M6\nF100\nPOCKET4(20,0,2,-4,1,0,0,2,0,0,500,100)\nM30",
        dialect="sinumerik",
        tool_table=table_of(tmp_path),
    )
    assert out.errors == [("cycle-tool", 3, 1)]


def test_subprograms_of_files(run: Any, tmp_path: Path) -> None:
    (tmp_path / "BOHREN.SPF").write_text("PROC BOHREN(REAL TIEFE)\nG0 Z=TIEFE C5\nRET\n")
    out = run("BOHREN(-5)\nM30", dialect="sinumerik", include=(tmp_path,))
    assert out.errors == []
    assert ends(out) == [(0, 0, -5)]
    assert out.axes == "XYZC"


@pytest.mark.parametrize(
    ("text", "mm_a_minute"),
    [
        ("G70 F100\nG1 X1", 100),
        ("F100\nG70 G1 X1", 100),
        ("G700 F10\nG1 X1", 254),
        ("F100 G700\nG1 X1 F10\nG71 X30 F50", 50),
    ],
)
def test_g70_changes_the_unit_of_lengths_alone(run: Any, text: str, mm_a_minute: float) -> None:
    """840D sl, Fundamentals: F is in the basic system under G70 and G71, and changes with G700 and G710."""
    path = run(f"{text}\nM30", dialect="sinumerik").path
    assert path.feed[path.kind < 3][-1] * 60.0 == pytest.approx(mm_a_minute)


@pytest.mark.parametrize(
    ("cdir", "spindle", "sense"), [(0, 3, -1), (0, 4, 1), (1, 3, 1), (2, 3, -1), (3, 3, 1)]
)
def test_a_spigot_is_milled_the_way_it_says(
    run: Any, tmp_path: Path, cdir: int, spindle: int, sense: int
) -> None:
    """The loop around a circle is four arcs of the radius of the wall and the tool; climb milling goes clockwise under M3."""
    cycle = f"CYCLE77(20,0,2,-4,,20,0,0,0,0,0,500,100,{cdir},1,20)"
    out = run(
        f"T1 M6\nS1000 M{spindle} F100\n{cycle}\nG1 X0\nM30",
        dialect="sinumerik",
        tool_table=table_of(tmp_path),
    )
    assert out.errors == []
    arcs = out.path.end[out.path.kind == Kind.ARC][:, :2]
    assert [tuple(p) for p in arcs.round(9).tolist()] == [
        (0, 12 * sense),
        (-12, 0),
        (0, -12 * sense),
        (12, 0),
    ]
    # F of the program is in force behind the cycle.
    assert out.path.feed[out.path.kind != 3][-1] == pytest.approx(100 / 60)


def test_an_arc_out_of_its_plane_begins_where_the_tool_is_after_another_origin(run: Any) -> None:
    """A half circle of radius 5 from X10 to X0 in a plane turned about X by 30 degrees; G55 names its start X0."""
    text = "G17 G90 F100\n$P_UIFR[2]=CTRANS(X,10)\nG54\nROT X30\nG1 X10 Y0 Z0\nG55\nG2 X-10 Y0 CR=5\nM30"
    out = run(text, dialect="sinumerik")
    assert out.errors == []
    y, z = -5.0 * math.cos(math.radians(30.0)), -2.5
    expected = [(10, 0, 0), (10, y, z), (5, y, z), (0, y, z), (0, 0, 0)]
    np.testing.assert_allclose(out.path.nurbs.control_points, expected, atol=1e-9)


@pytest.mark.parametrize(
    "lines",
    ["ASCALE X1000\n" * 3, "ASCALE X0.001 Y0.001\n" * 3, "ASCALE X0.0001\nAROT Z45\n" * 4],
)
def test_frames_that_leave_no_digits_are_refused(run: Any, lines: str) -> None:
    assert "number-range" in [
        code for code, _, _ in run(f"{lines}G1 X1 F100\nM30", dialect="sinumerik").errors
    ]


def test_an_m_function_that_is_not_the_controls_is_the_builders(run: Any) -> None:
    out = run("G71 G90\nG1 X5 F100\nM180\nM30\n", dialect="sinumerik")
    assert [(d.severity, d.code, d.span.line) for d in out.diagnostics] == [("warning", "builders-code", 3)]


@pytest.mark.parametrize(
    ("dialect", "text", "line"),
    [
        ("sinumerik", "G71 G1 X1 F100\nR1=2\nM30\nG1 X5", 3),
        ("sinumerik", "G71 G1 X1 F100\nR1=2\nM30\nREST: G1 X5", 0),
        ("sinumerik", "G71 G1 X1 F100\nIF R1==1 GOTOF N70\nM30\nN70 G1 X5", 0),
        ("sinumerik", "G71 G1 X1 F100\nUP1\nM30\nPROC UP1\nG1 X5\nM17", 0),
        ("heidenhain", "0 BEGIN PGM A MM\n1 L X+1 R0 F100\n2 M30\n3 L X+5\n4 END PGM A MM", 3),
        (
            "heidenhain",
            "0 BEGIN PGM A MM\n1 L X+1 R0 F100\n2 CALL LBL 1\n3 M30\n4 LBL 1\n5 L X+5\n6 LBL 0\n7 END PGM A MM",
            0,
        ),
    ],
)
def test_blocks_behind_the_end_that_nothing_leads_to_are_told(
    run: Any, dialect: str, text: str, line: int
) -> None:
    out = run(text + "\n", dialect=dialect)
    assert [d.span.line for d in out.diagnostics if d.code == "text-behind-end"] == ([line] if line else [])
